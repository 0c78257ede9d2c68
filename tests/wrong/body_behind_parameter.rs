#[constraint]
pub fn distance(a: Particle, rest: Real, b: Particle) -> Real {
    (b.position - a.position).norm_squared() - rest
}
