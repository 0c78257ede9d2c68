//! The force between two rigid bodies at a point where they touch.

use crate::prelude::*;

/// Contact of a ball on `b` with a ball on `a`, either of any radius, zero included: what two solids do at one point where
/// they touch, a corner on a face for example. A one-sided spring and damper along the normal, and Coulomb friction across
/// it.
///
/// With gap = n·(xb + qb·arm_b − xa − qa·arm_a) − radius_a − radius_b and v the velocity of `b` against `a` where they touch,
///
/// load = −stiffness·gap − damping·n·v, but no less than zero where gap ≥ 0,
/// F = load·n − max(load, 0) · μ · vₜ / speed on `b` and −F on `a`.
///
/// The load sets in before the bodies touch, where they would do so within the time damping / stiffness; and while they
/// overlap the damper holds them back too, so that about a state of rest the force is linear, and a step of an implicit
/// method, which linearises once, finds that state and stays there.
/// `speed` is the |vₜ| that is expected, which makes it Coulomb's law. It is a parameter since a step that linearises his law
/// where sliding is slow overshoots and reverses it; this force is linear in vₜ, and a step finds rest.
///
/// Both forces act at one point, so that their torques balance exactly.
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
