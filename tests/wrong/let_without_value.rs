#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d;
    d = k * a.position.dot(&b.position);
    d
}
