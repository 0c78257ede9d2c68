#[constraint]
#[domain(rest = 0.1..2.0, rest = 0.2..1.0)]
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}
