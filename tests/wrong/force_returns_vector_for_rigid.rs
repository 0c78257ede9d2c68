#[force]
pub fn drag(a: Rigid, k: Real) -> Vec3 {
    -k * a.velocity
}
