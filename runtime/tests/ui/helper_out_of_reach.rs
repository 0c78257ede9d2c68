use forcec_runtime::prelude::*;

fn raised(x: Real) -> Real {
    x * x
}

#[energy]
pub fn lift(p: Particle) -> Real {
    raised(p.position.z)
}

fn main() {}
