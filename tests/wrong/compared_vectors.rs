#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if a.position == b.position { k } else { 0.0 }
}
