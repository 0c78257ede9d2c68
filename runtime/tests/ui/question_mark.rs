use forcec_runtime::prelude::*;

#[energy]
pub fn lift(p: Particle, rest: Mat3) -> Real {
    rest.try_inverse()?.trace() * p.position.z
}

fn main() {}
