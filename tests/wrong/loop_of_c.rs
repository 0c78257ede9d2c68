#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    for (int i = 0; i < 3; i++) {}
    k * p.position.x
}
