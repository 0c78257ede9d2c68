#[constrant]
pub fn pin(a: Particle, target: Vec3) -> Vec3 {
    a.position - target
}
