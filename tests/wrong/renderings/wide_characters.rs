#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = /* 距離 */ b.position - a.positon; // the distance
    k * d.norm_squared()
}
