#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    let parts = (k, p.position.x);
    (parts.0, parts.2)
}

#[energy]
pub fn g(p: Particle) -> (Real, Real) {
    (p.position.x, 1.0)
}
