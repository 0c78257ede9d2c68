//! Joints between rigid bodies.
//!
//! Anchors and axes are given in body space and turned into the world by `q * arm`. The derivative of such a
//! rotated arm is a cross product, which is why positions and directions are written with them alone, and
//! entries of a quaternion appear only where a whole orientation is compared. Positions are subtracted from
//! each other before an arm is added: far from the origin that keeps all digits.
//!
//! A joint with rows in metres and rows in radians has one stiffness for all of them, N/m and N·m/rad; write
//! `#[constraint(per_row)]`, as `bushing` does, where they must differ.

use forcec_runtime::prelude::*;

/// Ball joint: the anchor on `a` meets the anchor on `b`.
///
/// `arm_a`, `arm_b`: anchors in body space, m.
#[constraint]
pub fn point_to_point(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    let pa = a.position + a.orientation * arm_a;
    let pb = b.position + b.orientation * arm_b;
    pb - pa
}

/// Ball joint by the distance of the anchors alone: one row, and singular where it is satisfied.
///
/// C = |pb − pa|, p = x + q·arm. The paper's first formulation, kept to compare with `point_to_point`, which
/// behaves far better: D'Amora et al., IBM Systems Journal 45(1), 2006.
///
/// `arm_a`, `arm_b`: anchors in body space, m.
#[constraint]
pub fn point_to_point_norm(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Real {
    gap_between(a, b, arm_a, arm_b).norm()
}

/// Distance joint, a massless rod: the anchors stay `rest_length` apart.
///
/// C = |pb − pa| − rest_length, p = x + q·arm.
///
/// `arm_a`, `arm_b`: anchors in body space, m. `rest_length`: m.
#[constraint]
#[domain(rest_length = 0.1..2.0)]
pub fn distance(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3, rest_length: Real) -> Real {
    gap_between(a, b, arm_a, arm_b).norm() - rest_length
}

/// Hinge: the anchors meet, and an axis of `a` stays at right angles to two directions of `b`.
///
/// C = (pb − pa, na·nb1, na·nb2), p = x + q·arm, n = q·axis. Five rows; what stays free is the turn about the
/// axis.
///
/// `arm_a`, `arm_b`: anchors in body space, m. `axis_a`: the hinge's axis in the space of `a`. `normal_b1`,
/// `normal_b2`: two directions in the space of `b`, at right angles to the axis and to each other.
#[constraint]
#[domain(axis_a = unit, normal_b1 = unit, normal_b2 = unit)]
pub fn hinge(
    a: Rigid,
    b: Rigid,
    arm_a: Vec3,
    arm_b: Vec3,
    axis_a: Vec3,
    normal_b1: Vec3,
    normal_b2: Vec3,
) -> (Vec3, Real, Real) {
    let axis = a.orientation * axis_a;
    let nb1 = b.orientation * normal_b1;
    let nb2 = b.orientation * normal_b2;
    (gap_between(a, b, arm_a, arm_b), axis.dot(&nb1), axis.dot(&nb2))
}

/// Universal joint: the anchors meet, and an axis of `a` stays at right angles to an axis of `b`.
///
/// C = (pb − pa, na·nb), p = x + q·arm, n = q·axis. The cross of a Cardan shaft.
///
/// `arm_a`, `arm_b`: anchors in body space, m. `axis_a`, `axis_b`: the two pins of the cross, each in the
/// space of its body.
#[constraint]
#[domain(axis_a = unit, axis_b = unit)]
pub fn universal(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3, axis_a: Vec3, axis_b: Vec3) -> (Vec3, Real) {
    let na = a.orientation * axis_a;
    let nb = b.orientation * axis_b;
    (gap_between(a, b, arm_a, arm_b), na.dot(&nb))
}

/// Slider: `b` slides along a line fixed in `a` and does not turn against `a`.
///
/// C = (n1·(pb − pa), n2·(pb − pa), 2 Im(qa⁻¹ qb rest⁻¹)), p = x + q·arm, n = qa·normal.
///
/// `arm_a`: a point of the line in the space of `a`, m. `arm_b`: the point of `b` that slides, m.
/// `normal_a1`, `normal_a2`: two directions in the space of `a`, at right angles to the line and to each
/// other. `rest`: the orientation of `b` as `a` sees it.
#[constraint]
#[domain(normal_a1 = unit, normal_a2 = unit)]
pub fn slider(
    a: Rigid,
    b: Rigid,
    arm_a: Vec3,
    arm_b: Vec3,
    normal_a1: Vec3,
    normal_a2: Vec3,
    rest: Quat,
) -> (Real, Real, Vec3) {
    let gap = gap_between(a, b, arm_a, arm_b);
    let n1 = a.orientation * normal_a1;
    let n2 = a.orientation * normal_a2;
    (n1.dot(&gap), n2.dot(&gap), turn_between(a, b, rest))
}

/// Weld: `b` is held to `a` in position and orientation.
///
/// C = (pb − pa, 2 Im(qa⁻¹ qb rest⁻¹)), p = x + q·arm. The second part is 2 sin(θ/2) times the axis of the
/// error: a polynomial, equal to the rotation vector for small errors and pulling back from every error short
/// of a half turn. q and −q give opposite rows and the same force.
///
/// `arm_a`, `arm_b`: anchors in body space, m. `rest`: the orientation of `b` as `a` sees it.
#[constraint]
pub fn fixed(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3, rest: Quat) -> (Vec3, Vec3) {
    (gap_between(a, b, arm_a, arm_b), turn_between(a, b, rest))
}

/// Bushing: a spring and a damper of their own along and about each axis of `a`.
///
/// C = (qa⁻¹·(pb − pa), log(qa⁻¹ qb rest⁻¹)), p = x + q·arm; the six rows are seen by `a`.
///
/// `arm_a`, `arm_b`: anchors in body space, m. `rest`: the orientation of `b` as `a` sees it.
#[constraint(per_row)]
pub fn bushing(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3, rest: Quat) -> (Vec3, Vec3) {
    let gap = gap_between(a, b, arm_a, arm_b);
    let turn = a.orientation.conjugate() * b.orientation * rest.conjugate();
    (a.orientation.conjugate() * gap, turn.scaled_axis())
}

/// Pin: a point of `a` is held at a point of the world.
///
/// C = x + q·arm − target.
///
/// `arm`: the point in body space, m. `target`: the point of the world, m.
#[constraint]
pub fn pin(a: Rigid, arm: Vec3, target: Vec3) -> Vec3 {
    (a.position - target) + a.orientation * arm
}

/// Attachment: a particle is held at a point of `b`, as cloth or hair is on a body.
///
/// C = xb + qb·arm − xp.
///
/// `arm`: the point in body space, m.
#[constraint]
pub fn attachment(p: Particle, b: Rigid, arm: Vec3) -> Vec3 {
    (b.position - p.position) + b.orientation * arm
}

/// Angular spring with damper: `b` turns back to its rest orientation against `a`.
///
/// C = log(qa⁻¹ qb rest⁻¹), the rotation vector of the error in the space of `a`: the torque grows with the
/// angle up to a half turn, where the shortest way back changes sides.
///
/// `rest`: the orientation of `b` as `a` sees it.
#[constraint]
pub fn angular_spring(a: Rigid, b: Rigid, rest: Quat) -> Vec3 {
    let turn = a.orientation.conjugate() * b.orientation * rest.conjugate();
    turn.scaled_axis()
}

/// Torsion spring with damper on a hinge: it turns one direction of `b` onto one of `a`.
///
/// C = θ = atan2((n × ua)·ub, ua·ub), n = qa·axis, u = q·normal.
///
/// `axis_a`: the hinge's axis in the space of `a`. `normal_a`, `normal_b`: directions at right angles to the
/// axis, each in the space of its body, that coincide when the spring is slack.
#[constraint]
#[domain(axis_a = unit, normal_a = unit, normal_b = unit)]
pub fn torsion_spring(a: Rigid, b: Rigid, axis_a: Vec3, normal_a: Vec3, normal_b: Vec3) -> Real {
    hinge_angle(a, b, axis_a, normal_a, normal_b)
}

/// Stops of a hinge: its angle stays between `lower` and `upper`.
///
/// C = (θ − lower, upper − θ), θ = atan2((n × ua)·ub, ua·ub), n = qa·axis, u = q·normal. θ lies in −π … π, so
/// leave some room between a stop and ±π.
///
/// `axis_a`: the hinge's axis in the space of `a`. `normal_a`, `normal_b`: directions at right angles to the
/// axis, each in the space of its body, that coincide at angle zero. `lower`, `upper`: rad.
#[constraint(unilateral)]
#[domain(axis_a = unit, normal_a = unit, normal_b = unit, lower = -3.0..0.0, upper = 0.0..3.0)]
pub fn hinge_limits(
    a: Rigid,
    b: Rigid,
    axis_a: Vec3,
    normal_a: Vec3,
    normal_b: Vec3,
    lower: Real,
    upper: Real,
) -> (Real, Real) {
    let angle = hinge_angle(a, b, axis_a, normal_a, normal_b);
    (angle - lower, upper - angle)
}

/// Stop of a ball joint: an axis of `b` stays within a cone about an axis of `a`.
///
/// C = (ua·ub − cos φ) / sin φ, u = q·axis: near the stop that is φ − θ in radians, and unlike the angle θ
/// itself it is smooth on the axis of the cone.
///
/// `axis_a`, `axis_b`: each in the space of its body. `half_angle`: φ, rad.
#[constraint(unilateral)]
#[domain(axis_a = unit, axis_b = unit, half_angle = 0.1..1.5)]
pub fn cone_limit(a: Rigid, b: Rigid, axis_a: Vec3, axis_b: Vec3, half_angle: Real) -> Real {
    let ua = a.orientation * axis_a;
    let ub = b.orientation * axis_b;
    let (sin, cos) = half_angle.sin_cos();
    (ua.dot(&ub) - cos) / sin
}

/// Motor on a hinge: it drives the rate at which `b` turns against `a` to a target, with a limited torque.
///
/// τ = limit · tanh(gain · (target_rate − n·(ωb − ωa)) / limit), n = qa·axis; +τ n acts on `b`, −τ n on `a`.
///
/// `axis_a`: the hinge's axis in the space of `a`. `target_rate`: rad/s. `gain`: torque for each unit of
/// missing rate while far from the limit, N·m·s/rad. `torque_limit`: N·m.
#[force]
#[domain(axis_a = unit, target_rate = -20.0..20.0, gain = 0.1..100.0, torque_limit = 1.0..1000.0)]
pub fn hinge_motor(
    a: Rigid,
    b: Rigid,
    axis_a: Vec3,
    target_rate: Real,
    gain: Real,
    torque_limit: Real,
) -> (Wrench, Wrench) {
    let axis = a.orientation * axis_a;
    let rate = axis.dot(&(b.angular_velocity - a.angular_velocity));
    let torque = axis * (torque_limit * (gain * (target_rate - rate) / torque_limit).tanh());
    (Wrench { force: Vec3::zeros(), torque: -torque }, Wrench { force: Vec3::zeros(), torque })
}

/// The way from the anchor on `a` to the anchor on `b`.
fn gap_between(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + (b.orientation * arm_b - a.orientation * arm_a)
}

/// How far `b` is turned from rest, in the space of `a`: 2 sin(θ/2) along the axis of the turn.
fn turn_between(a: Rigid, b: Rigid, rest: Quat) -> Vec3 {
    2.0 * (a.orientation.conjugate() * b.orientation * rest.conjugate()).imag()
}

/// The angle, −π … π, from a direction of `a` to a direction of `b`, counted about an axis of `a`.
fn hinge_angle(a: Rigid, b: Rigid, axis_a: Vec3, normal_a: Vec3, normal_b: Vec3) -> Real {
    let from = a.orientation * normal_a;
    let across = a.orientation * axis_a.cross(&normal_a);
    let to = b.orientation * normal_b;
    across.dot(&to).atan2(from.dot(&to))
}
