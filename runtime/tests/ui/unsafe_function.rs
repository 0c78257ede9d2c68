use forcec_runtime::prelude::*;

#[energy]
pub unsafe fn lift(p: Particle) -> Real {
    p.position.z
}

fn main() {}
