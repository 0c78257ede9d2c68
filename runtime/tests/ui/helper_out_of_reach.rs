use forcec_runtime::prelude::*;

fn square(x: Real) -> Real {
    x * x
}

#[energy]
pub fn lift(p: Particle) -> Real {
    square(p.position.z)
}

fn main() {}
