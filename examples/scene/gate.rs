//! A gate, its post, and the ground.

use forcec_runtime::prelude::*;

/// Hinge: a point of the gate stays on a point of the post, and its axis stays parallel to the post's z.
///
/// `arm_gate`, `arm_post`: anchors in body space, m. `axis`: unit vector in the gate's space.
#[constraint]
#[domain(axis = unit)]
pub fn hinge(gate: Rigid, post: Rigid, arm_gate: Vec3, arm_post: Vec3, axis: Vec3) -> (Vec3, Real, Real) {
    let at_gate = gate.position + gate.orientation * arm_gate;
    let at_post = post.position + post.orientation * arm_post;
    let turned = gate.orientation * axis;
    let across = post.orientation * Vec3::x();
    let along = post.orientation * Vec3::y();
    (at_gate - at_post, across.dot(&turned), along.dot(&turned))
}

/// Closer: a point of the gate stays within reach of a point of the post.
///
/// `arm_gate`, `arm_post`: anchors in body space, m. `reach`: m.
#[constraint]
#[domain(reach = 0.1..2.0)]
pub fn closer(gate: Rigid, post: Rigid, arm_gate: Vec3, arm_post: Vec3, reach: Real) -> Real {
    let at_gate = gate.position + gate.orientation * arm_gate;
    let at_post = post.position + post.orientation * arm_post;
    (at_gate - at_post).norm_squared() - reach * reach
}

/// Ground: a corner of the gate stays above a plane through the origin.
///
/// `corner`: in body space, m. `normal`: unit vector, out of the ground.
#[constraint(unilateral)]
#[domain(normal = unit)]
pub fn ground(gate: Rigid, corner: Vec3, normal: Vec3) -> Real {
    (gate.position + gate.orientation * corner).dot(&normal)
}

/// Weight: pulls the gate down.
///
/// `mass`: kg. `gravity`: m/s².
#[energy]
pub fn weight(gate: Rigid, mass: Real, gravity: Real) -> Real {
    mass * gravity * gate.position.z
}
