#[energy]
pub fn f(p: Particle, k: Real = 1.0) -> Real {
    k * p.position.x
}
