//! Fields.

use forcec_runtime::prelude::*;

/// Weight.
#[energy]
pub fn lift(p: Particle, mass: Real) -> Real {
    mass * p.positoin.z
}
