// stages: header, c, rust
// layout: dense, 1, prepare
/// Bar: an elastic bar of a rest length, an area and Young's modulus.
#[energy]
fn bar(p: Particle, q: Particle, rest_length: Real, area: Real, young: Real) -> Real {
    let strain = (q.position - p.position).norm() / rest_length - 1.0;
    0.5 * young * area * rest_length * strain * strain
}

/// Slope: a plane through the origin whose normal is of any length pushes a ball.
#[constraint(unilateral)]
fn slope(ball: Particle, normal: Vec3, radius: Real) -> Real {
    normal.normalize().dot(ball.position) - radius
}

/// Tie: nothing depends on parameters alone.
#[constraint]
fn tie(p: Particle, q: Particle) -> Vec3 {
    q.position - p.position
}
