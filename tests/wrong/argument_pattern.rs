#[energy]
pub fn well((a, b): (Particle, Particle)) -> Real {
    a.position.dot(&b.position)
}
