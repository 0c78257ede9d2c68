use forcec_runtime::prelude::*;

#[energy]
pub fn lift(p: Particle) -> Real {
    let square = |x: Real| x * x;
    square(p.position.z)
}

fn main() {}
