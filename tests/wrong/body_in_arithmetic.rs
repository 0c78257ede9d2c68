#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b - a).norm_squared()
}
