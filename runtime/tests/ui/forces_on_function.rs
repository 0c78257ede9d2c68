use forcec_runtime::prelude::*;

#[forces]
fn spring(p: Particle) -> Real {
    p.position.norm_squared()
}

fn main() {}
