#[constraint]
pub fn slow(a: Particle) -> Vec3 {
    a.velocity
}
