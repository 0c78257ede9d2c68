#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    if d.norm_squared() { k } else { 0.0 }
}
