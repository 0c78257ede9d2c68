const K = 1.0;

#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    K * k * p.position.x
}
