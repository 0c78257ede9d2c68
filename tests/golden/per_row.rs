// stages: derivative, schedule, header
#[constraint(per_row)]
pub fn anchor(p: Particle, target: Vec3) -> Vec3 {
    p.position - target
}
