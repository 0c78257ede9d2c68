#[energy]
#[domain(a.orientation = -1.0..1.0)]
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}
