#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = (b.position - a.position).norm();
    k * d ^ 2
}
