#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let pair = (k, a.position.dot(&b.position));
    pair[0]
}
