#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k ** 2.0 + p.position.x
}
