#[constraint]
pub fn pin(a: Particle, stiffness: Real) -> Vec3 {
    stiffness * a.position
}
