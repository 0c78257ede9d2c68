#[energy]
pub fn spring(a: Particle, b: Particle, k: Real, w: Vec5) -> Real {
    k * (b.position - a.position).norm_squared() * w.x
}
