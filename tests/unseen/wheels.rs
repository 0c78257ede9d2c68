//! Wheels, tyres and bearings.
//!
//! Tried here: a helper that returns a tuple of tuples and is called twice with unused parts; `||`
//! between a state and parameters.

use forcec_runtime::prelude::*;

/// The velocity split at a patch: ahead, sideways, and the two directions.
fn patch(wheel: Rigid, axle: Vec3, up: Vec3, r: Vec3) -> ((Vec3, Vec3), (Real, Real)) {
    let ahead = axle.cross(&up).normalize();
    let side = up.cross(&ahead);
    let velocity = wheel.velocity + wheel.angular_velocity.cross(&r);
    ((ahead, side), (velocity.dot(&ahead), velocity.dot(&side)))
}

/// Rolling resistance of a ball on the floor: a torque against the roll that does not grow with its speed.
#[force]
#[domain(up = unit, load = 1.0..100.0, lever = 0.001..0.01, ease = 0.01..0.1)]
pub fn rolling_resistance(ball: Rigid, up: Vec3, load: Real, lever: Real, ease: Real) -> Wrench {
    let roll = ball.angular_velocity - up * up.dot(&ball.angular_velocity);
    let pivot = ball.angular_velocity - roll;
    let smooth = (roll.norm_squared() + ease.powi(2)).sqrt().recip();
    Wrench { force: Vec3::zeros(), torque: -(load * lever) * (roll * smooth + 0.1 * pivot) }
}

/// Tyre with a slip angle: Pacejka's magic formula sideways, a friction ellipse ahead.
///
/// `magic`: the factors B, C, D, E.
#[force]
#[domain(axle = unit, up = unit, radius = 0.2..0.5, load = 100.0..1000.0, magic = 0.5..2.0, brake = 0.0..1.0)]
pub fn slip_tyre(
    wheel: Rigid,
    axle: Vec3,
    up: Vec3,
    radius: Real,
    load: Real,
    magic: Vec4,
    brake: Real,
) -> Wrench {
    let r = -radius * up;
    let ((ahead, side), (_, sliding)) = patch(wheel, wheel.orientation * axle, up, r);
    let ((_, _), (rolling, _)) = patch(wheel, wheel.orientation * axle, up, Vec3::zeros());
    let slip = sliding.atan2(rolling.abs() + 0.1);
    let bent = magic.x * slip;
    let sideways = magic.z * (magic.y * (bent - magic.w * (bent - bent.atan())).atan()).sin();
    let held = (1.0 - brake * brake).max(0.0).sqrt();
    let force = load * (side * (-sideways * held) - ahead * (brake * rolling / rolling.hypot(0.2)));
    Wrench { force, torque: r.cross(&force) }
}

/// Bearing after Stribeck: it sticks more than it slides, and then drags.
#[force]
#[domain(axis = unit, breakaway = 1.0..2.0, coulomb = 0.5..1.0, stribeck = 0.1..1.0, viscous = 0.0..0.5)]
#[allow(uncovered, reason = "no rate drawn is exactly zero")]
pub fn stribeck_bearing(
    shaft: Rigid,
    housing: Rigid,
    axis: Vec3,
    breakaway: Real,
    coulomb: Real,
    stribeck: Real,
    viscous: Real,
) -> (Wrench, Wrench) {
    let line = housing.orientation * axis;
    let rate = line.dot(&(shaft.angular_velocity - housing.angular_velocity));
    let stuck = (breakaway - coulomb) * (-(rate / stribeck).abs().powf(1.5)).exp();
    let level = if rate == 0.0 || breakaway < coulomb { 0.0 } else { (coulomb + stuck) * rate.signum() };
    let torque = line * (level + viscous * rate);
    (Wrench { force: Vec3::zeros(), torque: -torque }, Wrench { force: Vec3::zeros(), torque })
}
