#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let pair = (k, a.position - b.position);
    pair.2
}
