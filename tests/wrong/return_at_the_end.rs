#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    return k * a.position.dot(&b.position);
}
