use forcec_runtime::prelude::*;

#[constraint]
#[energy]
pub fn lift(p: Particle) -> Real {
    p.position.z
}

fn main() {}
