#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let n = k as usize;
    a.position[n] * b.position.x
}
