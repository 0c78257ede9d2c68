fn square(x: Real) -> Real {
    x * x
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * square(a.position.x, b.position.x)
}
