//! Muscle and tendon.
//!
//! Tried here: `points[i + 1]`, arithmetic on a loop variable in an index; `if` as an operand; a literal
//! with a suffix, `4.0f64`.

use forcec_runtime::prelude::*;

/// A path of three points and how fast it lengthens.
fn path(points: [Vec3; 3], velocities: [Vec3; 3]) -> (Real, Real) {
    let mut length = 0.0;
    let mut rate = 0.0;
    for i in 0..2 {
        let edge = points[i + 1] - points[i];
        let part = edge.norm();
        length += part;
        rate += edge.dot(&(velocities[i + 1] - velocities[i])) / part;
    }
    (length, rate)
}

/// The velocity of a point carried by a body.
fn carried(body: &Rigid, r: Vec3) -> Vec3 {
    body.velocity + body.angular_velocity.cross(&r)
}

/// Hill's muscle from a bone over a via point of the same bone to another bone.
///
/// `bell`: width of the force–length curve. `curvature`: of Hill's hyperbola.
#[force]
#[domain(
    origin = -0.5..0.5,
    via = -0.5..0.5,
    insertion = -0.5..0.5,
    activation = 0.0..1.0,
    strongest = 100.0..1000.0,
    optimum = 0.2..1.0,
    fastest = 1.0..10.0,
    bell = 0.3..0.6,
    curvature = 0.2..0.5
)]
pub fn hill_muscle(
    a: Rigid,
    b: Rigid,
    origin: Vec3,
    via: Vec3,
    insertion: Vec3,
    activation: Real,
    strongest: Real,
    optimum: Real,
    fastest: Real,
    bell: Real,
    curvature: Real,
) -> (Wrench, Wrench) {
    let ro = a.orientation * origin;
    let rv = a.orientation * via;
    let ri = b.orientation * insertion;
    let points = [a.position + ro, a.position + rv, b.position + ri];
    let (length, rate) = path(points, [carried(&a, ro), carried(&a, rv), carried(&b, ri)]);
    let fibre = length / optimum;
    let speed = rate / (optimum * fastest);
    let overlap = (-((fibre - 1.0) / bell).powi(2)).exp();
    let hill = if speed <= -1.0 {
        0.0
    } else if speed < 0.0 {
        (1.0 + speed) / (1.0 - speed / curvature)
    } else {
        let shape = 7.56 * speed / curvature;
        1.8 - 0.8 * (1.0 - speed) / (1.0 + shape) * (1.0 + 0.1 * speed.tanh())
    };
    let passive = if fibre > 1.0 { (4.0 * (fibre - 1.0) / 0.6).exp_m1() / 4.0f64.exp_m1() } else { 0.0 };
    let tension = strongest * (activation * overlap * hill + passive);
    let pull_a = (points[2] - points[1]).normalize() * tension;
    (
        Wrench { force: pull_a, torque: rv.cross(&pull_a) },
        Wrench { force: -pull_a, torque: ri.cross(&-pull_a) },
    )
}

/// Tendon: a toe region that grows as a power, then a straight line, joined with equal slope.
#[energy]
#[domain(slack = 0.2..1.0, toe = 0.01..0.05, power = 2.5..4.0, modulus = 10.0..1000.0)]
pub fn tendon(
    p: Particle,
    bone: Rigid,
    arm: Vec3,
    slack: Real,
    toe: Real,
    power: Real,
    modulus: Real,
) -> Real {
    let strain = ((bone.position - p.position) + bone.orientation * arm).norm() / slack - 1.0;
    modulus
        * slack
        * if strain <= 0.0 {
            0.0
        } else {
            let start = strain / toe;
            if start < 1.0 {
                toe * toe * start.powf(power) / power
            } else {
                let beyond = strain - toe;
                toe * toe / power + toe * beyond + 0.5 * (power - 1.0) * beyond * beyond
            }
        }
}
