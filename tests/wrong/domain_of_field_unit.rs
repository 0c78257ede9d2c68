#[energy]
#[domain(a.velocity = unit)]
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}
