use forcec_runtime::prelude::*;

#[energy(real = double)]
pub fn lift(p: Particle) -> Real {
    p.position.z
}

fn main() {}
