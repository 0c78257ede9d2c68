//! Nothing.

use forcec_runtime::prelude::*;

/// A square.
pub fn square(x: Real) -> Real {
    x * x
}
