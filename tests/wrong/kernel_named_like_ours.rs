#[energy]
pub fn forcec_rigid(a: Particle) -> Real {
    a.position.x
}
