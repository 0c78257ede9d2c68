// stages: graph, derivative, schedule, c
#[force]
pub fn thruster(a: Rigid, thrust: Vec3) -> Wrench {
    let force = a.orientation * thrust;
    Wrench { force, torque: Vec3::zeros() }
}
