#[energy]
#[domain(length = 1e-3)]
pub fn well(a: Rigid, length: Real) -> Real {
    a.position.norm_squared() / length
}
