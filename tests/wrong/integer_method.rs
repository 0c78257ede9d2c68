#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * 2.powi(3) * (b.position - a.position).norm_squared()
}
