#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    energy = k * p.position.x;
    energy
}
