#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if k < 0.0 {
        return 0.0;
    }
    k * a.position.dot(&b.position)
}
