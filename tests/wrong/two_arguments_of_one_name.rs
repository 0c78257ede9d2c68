#[energy]
pub fn well(a: Particle, a: Particle) -> Real {
    a.position.x
}
