#[energy]
pub fn spring(a: Particle, b: Particle, k: Real, m: Mat3) -> Real {
    m[0] * k * a.position.dot(&b.position)
}
