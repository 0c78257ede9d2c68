#[energy]
pub fn drop(p: Particle, k: Real) -> Real {
    let e = (k * p.position.x + k * p.position.y + k * p.position.z) * (p.position.x - p.position.y) * (p.position.y - p.position.z);
    e * (p.position.x * p.position.x + p.position.y * p.position.y + p.position.z * p.position.z - k * k).sqrt() + k * p.position.norm()
}
