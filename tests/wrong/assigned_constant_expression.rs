#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k = 2.0;
    k * a.position.dot(&b.position)
}
