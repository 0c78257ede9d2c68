#[energy]
pub fn spring(a: Rigid, k: Real) -> Real {
    let m: Mat3 = a.orientation.to_rotation_matrix();
    k * m.trace()
}
