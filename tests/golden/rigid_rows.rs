// stages: derivative, header, c, rust
/// Ball joint, for a solver that keeps C = 0 by multipliers: C, J and the drift of C.
#[constraint(outputs(value, jacobian, drift))]
fn ball(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + b.orientation * arm_b - a.orientation * arm_a
}

/// The same for given multipliers.
#[constraint(outputs(pull, geometric))]
fn ball_given(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + b.orientation * arm_b - a.orientation * arm_a
}

/// A stop: drift and pull of a one-sided row, whether the row pushes or not.
#[constraint(unilateral, outputs(rate, drift, pull))]
fn stop(a: Rigid, arm: Vec3, level: Real) -> Real {
    (a.position + a.orientation * arm).z - level
}
