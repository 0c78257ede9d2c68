//! Elastic bands.

use forcec_runtime::prelude::*;

/// Rubber band: pulls two particles together, and never pushes them apart.
///
/// E = stiffness/2 · s² with s = ½ (|x1 − x0|²/rest_length² − 1) where s > 0, else 0.
///
/// `rest_length`: m. `stiffness`: J.
#[energy]
#[domain(rest_length = 0.1..2.0, stiffness = 1.0..1e4)]
pub fn rubber_band(p0: Particle, p1: Particle, rest_length: Real, stiffness: Real) -> Real {
    let band = p1.position - p0.position;
    let strain = 0.5 * (band.norm_squared() / (rest_length * rest_length) - 1.0);
    if strain > 0.0 { 0.5 * stiffness * strain * strain } else { 0.0 }
}
