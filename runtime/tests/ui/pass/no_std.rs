//! A crate without the standard library that forbids unused code.

#![no_std]
#![forbid(unused)]

use forcec_runtime::prelude::*;

#[energy]
fn unused_function(p: Particle, k: Real) -> Real {
    k * PI * p.position.norm_squared()
}

#[constraint(layout = packed, outputs(value, jacobian))]
fn unused_kernel(p: Particle, q: Rigid) -> Vec3 {
    p.position - q.position
}

#[forces]
mod several {
    use core::f64::consts::PI;
    use forcec_runtime::prelude::{Particle, Real};

    const HALF: [Real; 2] = [0.5, 0.5 * PI];

    #[energy]
    fn unused_too(p: Particle) -> Real {
        HALF[1] * p.position.norm_squared()
    }
}

fn main() {}
