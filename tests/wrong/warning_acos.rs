#[energy]
#[domain(u = unit, v = unit)]
pub fn bend(a: Rigid, u: Vec3, v: Vec3) -> Real {
    (a.orientation * u).dot(&v).acos()
}
