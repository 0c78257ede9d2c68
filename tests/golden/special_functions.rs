// stages: graph, schedule, c, rust
#[constraint]
pub fn turn(a: Rigid) -> Vec3 {
    a.orientation.scaled_axis()
}
