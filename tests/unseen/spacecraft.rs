//! Ships, magnets and planets.
//!
//! Tried here: a product of three quaternions from vectors; a tuple `let`; typed `let`; a struct literal
//! in the other order.

use forcec_runtime::prelude::*;

/// Swivel of a nozzle: yaw after pitch.
fn swivel(tilt: Vec2) -> Quat {
    Quat::from_scaled_axis(Vec3::x() * tilt.x) * Quat::from_scaled_axis(Vec3::new(0.0, tilt.y, 0.0))
}

/// Thruster on a gimbal with soft stops: it pushes the ship against its jet, and turns it.
#[force]
#[domain(arm = -1.0..1.0, tilt = -0.5..0.5, thrust = 0.0..100.0, stop = 0.1..0.4)]
pub fn gimbal_thruster(ship: Rigid, mount: Quat, arm: Vec3, tilt: Vec2, thrust: Real, stop: Real) -> Wrench {
    let limited = Vec2::new(tilt.x.clamp(-stop, stop), tilt.y.min(stop).max(-stop));
    let nozzle = ship.orientation * mount * swivel(limited);
    let force = nozzle * (Vec3::z() * thrust);
    Wrench { force, torque: (ship.orientation * arm).cross(&force) }
}

/// Two magnets, each a dipole at the centre of its body.
#[energy]
#[domain(constant = 0.1..1.0, moment_a = -1.0..1.0, moment_b = -1.0..1.0)]
pub fn dipole_pair(a: Rigid, b: Rigid, constant: Real, moment_a: Vec3, moment_b: Vec3) -> Real {
    let r = b.position - a.position;
    let (ma, mb) = (a.orientation * moment_a, b.orientation * moment_b);
    let tensor = Mat3::identity() - 3.0 * r.outer(&r) / r.norm_squared();
    constant * r.norm().powi(-3) * ma.dot(&(tensor * mb))
}

/// Gravity of a planet on a long ship: the pull, and the torque of its gradient.
#[force]
#[domain(planet = 5.0..9.0, strength = 1.0..10.0, mass = 1.0..5.0, moments = 0.5..2.0)]
pub fn gravity_gradient(ship: Rigid, planet: Vec3, strength: Real, mass: Real, moments: Vec3) -> Wrench {
    let down: Vec3 = planet - ship.position;
    let distance: Real = down.norm();
    let turn: Mat3 = ship.orientation.to_rotation_matrix().into_inner();
    let inertia: Mat3 = turn * Mat3::from_diagonal(&moments) * turn.transpose();
    let scale = strength / distance.powi(3);
    let n = down / distance;
    let spread = inertia * n;
    let second = 0.5 * inertia.trace() - 2.5 * n.dot(&spread);
    let pull = down * (mass * scale) + 3.0 * scale / distance * (n * second + spread);
    Wrench { torque: n.cross(&spread) * (3.0 * scale), force: pull }
}
