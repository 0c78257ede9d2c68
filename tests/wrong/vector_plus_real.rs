#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position + 1.0;
    k * d.norm_squared()
}
