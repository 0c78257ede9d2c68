use forcec_runtime::prelude::*;

#[energy]
pub fn lift(p: Particle) -> Real {
    if p.position.z < 0.0 {
        return 0.0;
    }
    p.position.z
}

fn main() {}
