#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    2.0f16 * k * a.position.dot(&b.position)
}
