#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let energy = 0.0;
    energy += k * a.position.dot(&b.position);
    energy
}
