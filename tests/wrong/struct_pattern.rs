#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let Vec3 { x, y, z } = a.position - b.position;
    k * (x + y + z)
}
