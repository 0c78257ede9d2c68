// stages: graph, derivative, schedule
#[energy]
pub fn upright(a: Rigid) -> Real {
    a.orientation.w * a.orientation.w + a.orientation.i
}
