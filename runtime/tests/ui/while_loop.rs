use forcec_runtime::prelude::*;

#[energy]
pub fn lift(p: Particle) -> Real {
    let mut x = p.position.z;
    while x > 1.0 {
        x -= 1.0;
    }
    x
}

fn main() {}
