#[energy]
pub fn well(a: Particle, k: Real) -> Real {
    let x = a.position.x
    k * x
}
