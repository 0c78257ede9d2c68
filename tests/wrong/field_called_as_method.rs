#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b.position() - a.position).norm_squared()
}
