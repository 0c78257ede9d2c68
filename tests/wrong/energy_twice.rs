#[energy]
#[force]
pub fn floor(a: Particle) -> Real {
    a.position.z
}
