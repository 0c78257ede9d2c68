#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * a.position[99999999999999999999] * b.position.x
}
