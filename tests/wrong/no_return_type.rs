#[energy]
pub fn well(a: Particle) {
    a.position.x
}
