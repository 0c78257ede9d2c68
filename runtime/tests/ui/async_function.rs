use forcec_runtime::prelude::*;

#[energy]
pub async fn lift(p: Particle) -> Real {
    p.position.z
}

fn main() {}
