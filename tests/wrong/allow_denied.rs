#[energy]
#[deny(singular)]
#[expect(nonlinear, unused, reason = "to see")]
pub fn spring(p: Particle) -> Real {
    p.position.norm()
}
