use forcec_runtime::prelude::*;

#[constraint]
pub fn far(a: Particle, b: Particle) -> Real {
    let d = b.position - a.position;
    d.nrom()
}

fn main() {}
