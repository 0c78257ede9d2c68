#[energy]
pub fn well(a: Particle, n: usize) -> Real {
    n as Real * a.position.x
}
