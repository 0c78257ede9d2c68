//! Wet grains.
//!
//! Tried here: `!` before a comparison; `else if` with a default; an array of vectors made in place.

use forcec_runtime::prelude::*;

const CLOSEST: Real = 1.0e-3;

/// Liquid bridge between two wet grains: it pulls until it ruptures, and squeezes like a lubricant.
///
/// Willett et al. 2000 for the pull, Lian et al. 1993 for the rupture distance (1 + θ/2) V^(1/3).
#[force]
#[domain(
    radius = 0.2..1.0,
    tension = 0.01..0.1,
    contact_angle = 0.0..1.0,
    liquid = 1e-3..0.1,
    viscosity = 0.0..0.1
)]
pub fn capillary_bridge(
    a: Particle,
    b: Particle,
    radius: Real,
    tension: Real,
    contact_angle: Real,
    liquid: Real,
    viscosity: Real,
) -> (Vec3, Vec3) {
    let between = b.position - a.position;
    let away = between.normalize();
    let gap = between.norm() - 2.0 * radius;
    let rupture = (1.0 + 0.5 * contact_angle) * liquid.cbrt();
    let touching = 2.0 * PI * tension * radius * contact_angle.cos();
    let pull = if gap <= 0.0 {
        touching
    } else if gap < rupture && liquid > 0.0 {
        let reach = 0.5 * gap * (radius / liquid).sqrt();
        touching * (1.0 + 2.1 * reach + 10.0 * reach.powi(2)).recip()
    } else {
        0.0
    };
    let closing = (b.velocity - a.velocity).dot(&away);
    let squeeze = if !(gap > rupture) {
        1.5 * PI * viscosity * radius * radius * closing / gap.max(CLOSEST)
    } else {
        0.0
    };
    let force = away * (pull + squeeze);
    (force, -force)
}

/// Cohesion of dust: the Derjaguin–Muller–Toporov well with a Yukawa screen.
#[energy]
#[domain(depth = 0.1..1.0, screen = 0.5..5.0, core = 0.1..0.3)]
pub fn yukawa_dust(a: Particle, b: Particle, c: Particle, depth: Real, screen: Real, core: Real) -> Real {
    let sides = [b.position - a.position, c.position - b.position, a.position - c.position];
    let mut energy = 0.0;
    for k in 0..3 {
        let r = sides[k].norm().hypot(core);
        energy -= depth * (-r / screen).exp() / r;
    }
    energy
}
