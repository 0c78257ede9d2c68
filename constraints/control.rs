//! Control: servos that drive bodies to a target with limited force or torque.
//!
//! They saturate smoothly, by tanh or by f / √(1 + |f|²/limit²), so that an implicit integrator sees their
//! slope everywhere.

use forcec_runtime::prelude::*;

/// Servo on a hinge: proportional to the missing angle and to the missing rate, with limited torque.
///
/// τ = limit · tanh((kp · e + kd · (target_rate − n·(ωb − ωa))) / limit), n = qa·axis, where the error
/// e = target_angle − θ is taken the short way round; +τ n acts on `b`, −τ n on `a`.
///
/// `axis_a`: the hinge's axis in the space of `a`. `normal_a`, `normal_b`: directions at right angles to the
/// axis, each in the space of its body, that coincide at angle zero. `target_angle`: rad. `target_rate`:
/// rad/s. `proportional`: kp, N·m/rad. `derivative`: kd, N·m·s/rad. `torque_limit`: N·m.
#[force]
#[domain(
    axis_a = unit,
    normal_a = unit,
    normal_b = unit,
    target_angle = -3.0..3.0,
    target_rate = -20.0..20.0,
    proportional = 1.0..1000.0,
    derivative = 0.1..100.0,
    torque_limit = 1.0..1000.0
)]
pub fn hinge_servo(
    a: Rigid,
    b: Rigid,
    axis_a: Vec3,
    normal_a: Vec3,
    normal_b: Vec3,
    target_angle: Real,
    target_rate: Real,
    proportional: Real,
    derivative: Real,
    torque_limit: Real,
) -> (Wrench, Wrench) {
    let axis = a.orientation * axis_a;
    let from = a.orientation * normal_a;
    let across = a.orientation * axis_a.cross(&normal_a);
    let to = b.orientation * normal_b;
    let rate = axis.dot(&(b.angular_velocity - a.angular_velocity));

    // The angle of the target seen from the present direction, so that the error never jumps by a full turn.
    let sin_angle = across.dot(&to);
    let cos_angle = from.dot(&to);
    let (sin_target, cos_target) = target_angle.sin_cos();
    let error = (sin_target * cos_angle - cos_target * sin_angle)
        .atan2(cos_target * cos_angle + sin_target * sin_angle);

    let wanted = proportional * error + derivative * (target_rate - rate);
    let torque = axis * (torque_limit * (wanted / torque_limit).tanh());
    (Wrench { force: Vec3::zeros(), torque: -torque }, Wrench { force: Vec3::zeros(), torque })
}

/// Servo of orientation: a torque turns a body to a target orientation and brakes its spin there.
///
/// torque = saturate(kp · log(target q⁻¹) − kd · ω), the rotation vector log taken the short way round.
///
/// `target`: orientation. `proportional`: kp, N·m/rad. `derivative`: kd, N·m·s/rad. `torque_limit`: N·m.
#[force]
#[domain(proportional = 1.0..1000.0, derivative = 0.1..100.0, torque_limit = 1.0..1000.0)]
pub fn orientation_servo(
    a: Rigid,
    target: Quat,
    proportional: Real,
    derivative: Real,
    torque_limit: Real,
) -> Wrench {
    let error = (target * a.orientation.conjugate()).scaled_axis();
    let wanted = error * proportional - a.angular_velocity * derivative;
    Wrench { force: Vec3::zeros(), torque: saturate(wanted, torque_limit) }
}

/// Servo of position: a force drags a point of a body to a point of the world, as a hand or a mouse does.
///
/// F = saturate(kp · (target − p) − kd · ṗ) at p = x + r, r = q·arm; torque r × F.
///
/// `arm`: the point in body space, m. `target`: the point of the world, m. `proportional`: kp, N/m.
/// `derivative`: kd, N·s/m. `force_limit`: N.
#[force]
#[domain(proportional = 1.0..1e4, derivative = 0.1..1e3, force_limit = 1.0..1e4)]
pub fn position_servo(
    a: Rigid,
    arm: Vec3,
    target: Vec3,
    proportional: Real,
    derivative: Real,
    force_limit: Real,
) -> Wrench {
    let r = a.orientation * arm;
    let error = (target - a.position) - r;
    let velocity = a.velocity + a.angular_velocity.cross(&r);
    let force = saturate(error * proportional - velocity * derivative, force_limit);
    Wrench { force, torque: r.cross(&force) }
}

/// The same direction with a length that never reaches the limit.
fn saturate(wanted: Vec3, limit: Real) -> Vec3 {
    wanted / (1.0 + wanted.norm_squared() / (limit * limit)).sqrt()
}
