// stages: derivative, schedule, c
#[constraint(unilateral)]
pub fn floor(p: Particle) -> Real {
    p.position.z
}
