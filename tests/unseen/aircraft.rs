//! Wings and rotors.
//!
//! Tried here: a helper that takes arrays by value and by reference and returns a tuple out of nested
//! branches; vector accumulators.

use forcec_runtime::prelude::*;

const STALL: Real = 0.26;
const ROTORS: usize = 4;

/// Coefficients of lift and drag: a polynomial before the stall, a flat plate after it, a fade between.
fn polar(angle: Real, lift: [Real; 3], drag: &[Real; 3]) -> (Real, Real) {
    let (sin, cos) = angle.sin_cos();
    if angle.abs() < STALL {
        let mut cl = 0.0;
        let mut cd = 0.0;
        let mut power = 1.0;
        for k in 0..3 {
            cl += lift[k] * power;
            cd += drag[k] * power;
            power *= angle;
        }
        (cl, cd)
    } else if angle.abs() < 2.0 * STALL {
        let fade = (angle.abs() / STALL - 1.0).powf(1.5);
        if angle > 0.0 { (fade * 2.0 * sin * cos, 2.0 * fade * sin * sin) } else { (sin * cos, sin.powi(2)) }
    } else {
        (2.0 * sin * cos, 2.0 * sin * sin)
    }
}

/// Airfoil: lift and drag by the angle of attack, at its quarter chord.
#[force]
#[domain(
    arm = -1.0..1.0,
    air = -5.0..5.0,
    density = 0.5..1.5,
    area = 0.1..1.0,
    lift = -6.0..6.0,
    drag = 0.0..1.0
)]
#[allow(uncovered, reason = "the fade counts for positive angles alone")]
pub fn airfoil(
    plane: Rigid,
    arm: Vec3,
    air: Vec3,
    density: Real,
    area: Real,
    lift: [Real; 3],
    drag: [Real; 3],
) -> Wrench {
    let r = plane.orientation * arm;
    let chord = plane.orientation * Vec3::x();
    let up = plane.orientation * Vec3::z();
    let span = plane.orientation * Vec3::y();
    let wind = air - plane.velocity - plane.angular_velocity.cross(&r);
    let flat = wind - span * span.dot(&wind);
    let angle = up.dot(&flat).atan2(-chord.dot(&flat));
    let (cl, cd) = polar(angle, lift, &drag);
    let pressure = 0.5 * density * area;
    let force = pressure * flat.norm() * (flat.cross(&-span) * cl + flat * cd);
    Wrench { force, torque: r.cross(&force) }
}

/// Quadrotor: thrust, reaction torque, and the drag of each rotor's disc, which is linear in the speed.
#[force]
#[domain(
    hubs = -0.5..0.5,
    speeds = -10.0..10.0,
    thrust = 0.01..0.1,
    reaction = 0.001..0.01,
    flapping = 0.001..0.01
)]
pub fn rotor_drag(
    craft: Rigid,
    hubs: [Vec3; 4],
    speeds: [Real; 4],
    thrust: Real,
    reaction: Real,
    flapping: Real,
) -> Wrench {
    let shaft = craft.orientation * Vec3::z();
    let mut force = Vec3::zeros();
    let mut torque = Vec3::zeros();
    for i in 0..ROTORS {
        let hub = craft.orientation * hubs[i];
        let velocity = craft.velocity + craft.angular_velocity.cross(&hub);
        let sideways = velocity - shaft.dot(&velocity) * shaft;
        let push = shaft * (thrust * speeds[i] * speeds[i]) - sideways * (flapping * speeds[i].abs());
        force += push;
        torque += hub.cross(&push);
        torque -= shaft * (reaction * speeds[i].signum() * speeds[i].powi(2));
    }
    Wrench { force, torque }
}
