#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.positon - a.position;
    k * d.norm_squared()
}
