#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    const N: usize = 0;
    a.position[3 / N] * k * b.position.x
}
