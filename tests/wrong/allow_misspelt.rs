#[energy]
#[allow(singluar, reason = "the spring is never short")]
pub fn spring(p: Particle) -> Real {
    p.position.norm()
}
