use forcec_runtime::prelude::*;

#[constraint]
pub fn far(a: Particle, b: Particle, rest: Real) -> Real {
    let d = b.position - a.positoin;
    let length = d.norm();
    lenght - rest
}

fn main() {}
