#[energy]
#[domain(k.position = -1.0..1.0)]
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}
