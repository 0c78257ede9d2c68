fn even(x: Real) -> Real {
    odd(x - 1.0)
}

fn odd(x: Real) -> Real {
    even(x - 1.0)
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * even(a.position.dot(&b.position))
}
