#[energy]
pub fn well(a: Particle, k: Real) -> Real {
    k × a.position.x
}
