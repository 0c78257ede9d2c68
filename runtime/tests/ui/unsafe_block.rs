use forcec_runtime::prelude::*;

#[energy]
pub fn lift(p: Particle) -> Real {
    unsafe { p.position.z }
}

fn main() {}
