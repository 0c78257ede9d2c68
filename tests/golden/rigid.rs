// stages: graph, derivative, optimized
#[constraint]
pub fn hang(a: Rigid, arm: Vec3) -> Real {
    (a.orientation * arm).z + a.position.z
}
