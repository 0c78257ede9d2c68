use forcec_runtime::prelude::*;

#[forces(precision = f32)]
mod springs {}

fn main() {}
