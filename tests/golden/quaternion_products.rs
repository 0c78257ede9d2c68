// stages: graph, derivative
#[constraint]
pub fn align(a: Rigid, b: Rigid, rest: Quat) -> Vec3 {
    (a.orientation.conjugate() * b.orientation * rest.inverse()).imag()
}
