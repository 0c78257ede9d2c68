//! Orientations, by the quaternion's own entries.
//!
//! Tried here: `.i .j .k .w`, `angle_to`, arrays of quaternions; a quaternion made of a velocity.

use forcec_runtime::prelude::*;

/// Twist about z and the swing that is left, of the turn from one body to another.
fn swing_twist(a: Rigid, b: Rigid) -> (Quat, Real) {
    let turn = a.orientation.inverse() * b.orientation;
    let twist = 2.0 * turn.k.atan2(turn.w);
    (turn * Quat::from_scaled_axis(Vec3::z() * -twist), twist)
}

/// Flexible coupling: soft about z, stiff in the swing.
#[constraint(per_row)]
#[allow(uncovered, reason = "the swing never turns by more than half a turn")]
pub fn flexible_coupling(a: Rigid, b: Rigid, phase: Real) -> (Vec2, Real) {
    let (swing, twist) = swing_twist(a, b);
    let way = swing.scaled_axis();
    (Vec2::new(way.x, way.y), twist - phase)
}

/// Gyro horizon: the body is drawn to the nearer of two attitudes, and away from the sum of both.
#[energy]
#[domain(strength = 0.5..2.0)]
pub fn two_attitudes(body: Rigid, targets: [Quat; 2], strength: Real) -> Real {
    let first = body.orientation.angle_to(&targets[0]);
    let second = (targets[1].conjugate() * body.orientation).angle();
    let blend = Quat::identity() * targets[0] * targets[1];
    let shared = blend.imag().dot(&body.orientation.imag()) + blend.w * body.orientation.w;
    0.5 * strength * first.min(second).powi(2) + 0.1 * shared * shared
}

/// Compass needle: the entries of the quaternion as a vector of four, in a field that turns with the needle's
/// spin.
#[force]
#[domain(field = -1.0..1.0, lag = 0.0..0.1)]
pub fn compass_needle(needle: Rigid, field: Vec3, lag: Real) -> Wrench {
    let q = needle.orientation;
    let entries = Vec4::new(q.i, q.j, q.k, q.w);
    let trust = entries.norm_squared() * entries.dot(&Vec4::w());
    let delayed = Quat::from_scaled_axis(needle.angular_velocity * -lag) * field;
    let north = q * (Vec3::x() + 0.1 * Vec3::y());
    let torque = north.cross(&delayed) * (1.0 + 0.01 * trust) - 0.1 * q.scaled_axis() * q.angle();
    Wrench { force: (entries - Vec4::x()).norm() * Vec3::zeros(), torque }
}
