#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if !k { 1.0 } else { a.position.dot(&b.position) }
}
