#[energy]
pub fn well(a: Particle) -> Vec3 {
    a.position
}
