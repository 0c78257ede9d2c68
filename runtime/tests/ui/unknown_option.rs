use forcec_runtime::prelude::*;

#[constraint(unilatral)]
pub fn floor(p: Particle) -> Real {
    p.position.z
}

fn main() {}
