#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (a.position.x % b.position.x)
}
