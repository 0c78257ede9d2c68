#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * sqrt((b.position - a.position).norm_squared() + 1.0)
}
