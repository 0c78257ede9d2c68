use forcec_runtime::prelude::*;

#[forces(real = f16)]
mod springs {}

fn main() {}
