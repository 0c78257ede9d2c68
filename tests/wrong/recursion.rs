fn factorial(x: Real) -> Real {
    x * factorial(x - 1.0)
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * factorial(a.position.dot(&b.position))
}
