#[energy]
pub fn spring(a: Particle, b: Particle, ω: Real) -> Real {
    ω * a.position.dot(&b.position)
}
