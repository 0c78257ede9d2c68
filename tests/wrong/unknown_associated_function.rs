#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * Vec3::x_axis().dot(&(b.position - a.position))
}
