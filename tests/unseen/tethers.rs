//! Lines that pull and never push.
//!
//! Tried here: Newton steps by `for _`, `0..STEPS`; a branch whose derivative is NaN where it is not
//! taken; a `Vec2` of gaps.

use forcec_runtime::prelude::*;

const STEPS: usize = 4;

/// Kite on two lines, each slack until its length is used up.
#[constraint(unilateral, per_row)]
#[domain(lengths = 0.5..2.0)]
pub fn two_lines(hand: Particle, kite: Rigid, bridles: [Vec3; 2], lengths: Vec2) -> Vec2 {
    let left = hand.position - (kite.position + kite.orientation * bridles[0]);
    let right = hand.position - (kite.position + kite.orientation * bridles[1]);
    lengths - Vec2::new(left.norm(), right.norm())
}

/// Heavy tether between a buoy and a hull: a catenary while it is longer than the way, a spring when it is
/// not.
///
/// The catenary parameter solves sinh(x)/x = √(L² − v²)/h by Newton steps that start from x² = 6 (ratio − 1).
#[force]
#[domain(
    arm = -0.3..0.3,
    length = 1.0..4.0,
    weight = 0.1..2.0,
    stiffness = 10.0..1000.0,
    damping = 0.0..10.0
)]
pub fn catenary_tether(
    buoy: Particle,
    hull: Rigid,
    arm: Vec3,
    length: Real,
    weight: Real,
    stiffness: Real,
    damping: Real,
) -> (Vec3, Wrench) {
    let r = hull.orientation * arm;
    let way = (hull.position - buoy.position) + r;
    let chord = way.norm();
    let ahead = Vec3::new(way.x, way.y, 0.0);
    let span = way.x.hypot(way.y);
    let rise = way.z;
    let on_buoy = if chord < 0.98 * length && span > 0.05 * length {
        let ratio = (length * length - rise * rise).sqrt() / span;
        let mut x = (6.0 * (ratio - 1.0)).sqrt();
        for _ in 0..STEPS {
            x -= (x.sinh() - ratio * x) / (x.cosh() - ratio);
        }
        let pull = 0.5 * weight * span / x;
        let low = 0.5 * weight * (rise * x.cosh() / x.sinh() - length);
        ahead / span * pull + Vec3::z() * low
    } else if chord >= length {
        let along = way / chord;
        let rate = along.dot(&(hull.velocity + hull.angular_velocity.cross(&r) - buoy.velocity));
        along * (stiffness * (chord - length) + damping * rate).max(0.0)
    } else {
        Vec3::zeros()
    };
    let on_hull = Vec3::zeros() - on_buoy - Vec3::z() * (weight * length);
    (on_buoy, Wrench { force: on_hull, torque: r.cross(&on_hull) })
}
