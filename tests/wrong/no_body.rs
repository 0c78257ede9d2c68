#[energy]
pub fn nothing(k: Real) -> Real {
    k
}
