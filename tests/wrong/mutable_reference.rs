fn shift(x: &mut Real) {
    *x += 1.0;
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    shift(&mut k);
    k * a.position.dot(&b.position)
}
