//! Machines that couple a turn to a turn, or a turn to a shift.
//!
//! Tried here: a constant made of constants; `&T` in helpers; nested tuple patterns with `_`; a vector
//! and a matrix entry as rows.

use forcec_runtime::prelude::*;

const FULL_TURN: Real = 2.0 * PI;

/// The rate at which a body spins about an axis of the world.
fn spin_about(axis: &Vec3, body: &Rigid) -> Real {
    axis.dot(&body.angular_velocity)
}

/// The turn about `axis` from one direction to another, and how well they stay in one plane.
fn turn_and_tilt(axis: &Vec3, from: &Vec3, to: &Vec3) -> (Real, (Real, Real)) {
    let turn = axis.dot(&from.cross(to)).atan2(from.dot(to));
    (turn, (axis.dot(from), axis.dot(to)))
}

/// Belt over two pulleys: dry grip up to the capstan limit, and the pull of the preload on both shafts.
///
/// `axis_a`: both shafts, in the space of `a`. `radius_a`, `radius_b`: m. `preload`: N. `friction`: of the
/// belt. `creep`: slip speed of full grip, m/s.
#[force]
#[domain(
    axis_a = unit,
    radius_a = 0.1..0.3,
    radius_b = 0.1..0.3,
    preload = 1.0..100.0,
    friction = 0.1..0.9,
    creep = 0.01..0.1
)]
pub fn belt_drive(
    a: Rigid,
    b: Rigid,
    axis_a: Vec3,
    radius_a: Real,
    radius_b: Real,
    preload: Real,
    friction: Real,
    creep: Real,
) -> (Wrench, Wrench) {
    let axis = a.orientation * axis_a;
    let between = b.position - a.position;
    let ratio = ((radius_b - radius_a) / between.norm()).clamp(-0.99, 0.99);
    let wrap = PI - 2.0 * ratio.asin().abs();
    let capstan = preload * (friction * wrap).exp_m1();
    let slip = radius_a * spin_about(&axis, &a) - radius_b * spin_about(&axis, &b);
    let tension = capstan * (slip / creep).tanh();
    let pull = between.normalize() * (2.0 * preload + tension.abs());
    (
        Wrench { torque: -(axis * (tension * radius_a)), force: pull },
        Wrench { torque: axis * (tension * radius_b), force: -pull },
    )
}

/// Rack and pinion: the rack travels by the arc that the pinion turns.
#[constraint]
#[domain(axis = unit, spoke = unit, along = unit, up = unit, radius = 0.05..0.5)]
pub fn rack_and_pinion(
    pinion: Rigid,
    rack: Rigid,
    axis: Vec3,
    spoke: Vec3,
    along: Vec3,
    up: Vec3,
    radius: Real,
) -> (Real, Real) {
    let shaft = pinion.orientation * axis;
    let (turn, (_, tilt)) = turn_and_tilt(&shaft, &(rack.orientation * up), &(pinion.orientation * spoke));
    let travel = (rack.orientation * along).dot(&(pinion.position - rack.position));
    (travel - radius * turn, tilt)
}

/// Screw: a nut advances by `pitch` a turn, and stays on its bolt.
#[constraint(per_row)]
#[domain(pitch = 0.01..0.2)]
pub fn screw_joint(bolt: Rigid, nut: Rigid, frame: Quat, pitch: Real) -> (Vec2, Real, Vec2) {
    let axes = (bolt.orientation * frame).to_rotation_matrix().into_inner();
    let marks = nut.orientation.to_rotation_matrix().into_inner();
    let seen = axes.transpose() * (nut.position - bolt.position);
    let turned = axes.transpose() * marks;
    let turn = turned[(1, 0)].atan2(turned[(0, 0)]);
    let offset = Vec2::new(seen.x, seen.y);
    let tilt = Vec2::new(turned[(0, 2)], turned[(1, 2)]);
    (offset, seen[2] - pitch * turn / FULL_TURN, tilt)
}
