#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    p.position.norm_squared();
    k * p.position.x
}
