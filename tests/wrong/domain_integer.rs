#[constraint]
#[domain(rest = 0..2)]
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}
