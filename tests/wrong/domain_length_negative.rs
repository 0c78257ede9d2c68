#[energy]
#[domain(length = -1e-3)]
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}
