#[energy]
pub fn well(a: Particle) -> Real {
    a.position.x