#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    match k {
        _ => a.position.dot(&b.position),
    }
}
