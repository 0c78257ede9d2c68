#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let (x, y, z) = b.position - a.position;
    k * (x + y + z)
}
