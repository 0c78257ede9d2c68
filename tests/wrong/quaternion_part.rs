#[energy]
pub fn spring(a: Rigid, k: Real) -> Real {
    k * a.orientation.x
}
