use forcec_runtime::prelude::*;

static GRAVITY: Real = 9.81;

#[energy]
pub fn lift(p: Particle, mass: Real) -> Real {
    mass * GRAVITY * p.position.z
}

fn main() {}
