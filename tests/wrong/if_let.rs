#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if let d = k { d * a.position.dot(&b.position) } else { 0.0 }
}
