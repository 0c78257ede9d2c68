#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    0.5 * k * d.nrom().powi(2)
}
