//! One joint, two formulations: its three rows, or the one row of their length.

/// Two particles meet, by rows.
#[constraint]
pub fn meet(a: Particle, b: Particle) -> Vec3 {
    b.position - a.position
}

/// Two particles meet, by their distance.
#[constraint]
pub fn meet_norm(a: Particle, b: Particle) -> Real {
    (b.position - a.position).norm()
}

/// A ball joint, by rows.
#[constraint]
pub fn ball(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    gap(a, b, arm_a, arm_b)
}

/// A ball joint, by the distance of the anchors.
#[constraint]
pub fn ball_norm(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Real {
    gap(a, b, arm_a, arm_b).norm()
}

/// The way from the anchor on `a` to the anchor on `b`.
fn gap(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + (b.orientation * arm_b - a.orientation * arm_a)
}
