#[constraint]
#[domain(rest = unit)]
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}
