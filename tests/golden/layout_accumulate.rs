// stages: header, c, rust
// layout: accumulate, 1
/// Floor: a ball of a radius pushes off a plane, and does nothing above it.
#[constraint(unilateral)]
fn floor(ball: Particle, normal: Vec3, height: Real, radius: Real) -> Real {
    normal.dot(ball.position) - height - radius
}
