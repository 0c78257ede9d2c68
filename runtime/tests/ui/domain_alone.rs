use forcec_runtime::prelude::*;

#[domain(height = 0.0..1.0)]
pub fn lift(p: Particle, height: Real) -> Real {
    p.position.z - height
}

fn main() {}
