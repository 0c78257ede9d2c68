use forcec_runtime::prelude::*;

#[energy]
pub fn lift<T: Into<Real>>(p: Particle, weight: T) -> Real {
    weight.into() * p.position.z
}

fn main() {}
