#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k.min(f64::MAX) + Real::EPSILON + f64::INFINITY * p.position.x
}
