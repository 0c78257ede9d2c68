#[energy]
pub fn f(a: Rigid) -> Real {
    (a.orientation + a.orientation).w + (2.0 * a.orientation).w
}
