#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = if k > 0.0 {
        b.position - a.position
    } else {
        0.0
    };
    k * d.norm_squared()
}
