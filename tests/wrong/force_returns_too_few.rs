#[force]
pub fn pull(a: Rigid, b: Particle, k: Real) -> Wrench {
    Wrench { force: k * (b.position - a.position), torque: Vec3::zeros() }
}
