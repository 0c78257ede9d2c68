#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let v = [];
    k * a.position.dot(&b.position)
}
