#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let delta = b.position - a.position;
    k * detla.norm_squared()
}
