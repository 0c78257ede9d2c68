#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    (k > 0.0) * p.position.x
}
