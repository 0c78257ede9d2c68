#[constraint]
pub fn shape(a: Rigid) -> Mat3 {
    a.orientation.to_rotation_matrix().into_inner()
}
