// stages: graph, schedule, c, rust
#[energy]
pub fn lean(p: Particle, turn: Vec3) -> Real {
    (Quat::from_scaled_axis(turn) * p.position).x
}
