#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    1e999 * k * a.position.dot(&b.position)
}
