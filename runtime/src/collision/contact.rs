//! The force between two rigid bodies at a point where they touch.

use crate::prelude::*;

/// Contact of two balls of any radius, zero included, on bodies `a` and `b`: a point where two solids touch,
/// for example a corner on a face. A one-sided spring and damper along the normal, with Coulomb friction.
///
/// With gap = n·(xb + qb·arm_b − xa − qa·arm_a) − radius_a − radius_b and v the velocity of `b` relative to
/// `a` at the contact,
///
/// load = −stiffness·gap − damping·n·v, but no less than zero where gap ≥ 0,
/// F = load·n − max(load, 0) · μ · vₜ / speed on `b` and −F on `a`.
///
/// The load begins before the bodies touch, if they would touch within the time damping / stiffness. While
/// the bodies overlap, the damper also resists separation, so the force is linear near rest: a linearly
/// implicit step reaches the state of rest and stays there. `speed` is an estimate of |vₜ|; with the exact
/// |vₜ| the friction is Coulomb's law. It is a parameter because a step that linearises Coulomb's law
/// overshoots at low sliding speed and reverses the motion; with a constant `speed` friction is linear in vₜ,
/// and a step reaches rest.
///
/// Both forces act at the same point, so their torques balance exactly.
///
/// `arm_a`, `arm_b`: the balls' centres in body space, m. `normal`: n, a unit vector from `a` to `b` in the world frame.
/// `radius_a`, `radius_b`: m. `stiffness`: N/m. `damping`: N·s/m. `friction`: μ. `speed`: m/s.
#[force]
#[domain(
    normal = unit,
    radius_a = 0.0..1.0,
    radius_b = 0.0..1.0,
    stiffness = 1e2..1e6,
    damping = 0.0..1e3,
    friction = 0.0..1.5,
    speed = 1e-3..1e1
)]
pub fn point_contact(
    a: Rigid,
    b: Rigid,
    arm_a: Vec3,
    arm_b: Vec3,
    normal: Vec3,
    radius_a: Real,
    radius_b: Real,
    stiffness: Real,
    damping: Real,
    friction: Real,
    speed: Real,
) -> (Wrench, Wrench) {
    let between = b.position - a.position;
    let rb = b.orientation * arm_b;
    let gap = normal.dot(&(between + (rb - a.orientation * arm_a))) - (radius_a + radius_b);
    let rb = rb - normal * radius_b;
    let ra = between + rb;
    let velocity =
        (b.velocity - a.velocity) + (b.angular_velocity.cross(&rb) - a.angular_velocity.cross(&ra));
    let rate = normal.dot(&velocity);
    let push = -stiffness * gap - damping * rate;
    let load = if gap < 0.0 { push } else { push.max(0.0) };
    let sliding = velocity - normal * rate;
    let force = normal * load - sliding * (load.max(0.0) * friction / speed);
    (Wrench { force: -force, torque: -ra.cross(&force) }, Wrench { force, torque: rb.cross(&force) })
}
