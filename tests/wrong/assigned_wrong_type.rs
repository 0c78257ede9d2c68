#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut energy = 0.0;
    energy += a.position - b.position;
    k * energy
}
