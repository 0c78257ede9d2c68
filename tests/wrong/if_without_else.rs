#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = a.position.dot(&b.position);
    let s = if d < 0.0 { k };
    s * d
}
