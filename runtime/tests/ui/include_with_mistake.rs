use forcec_runtime::prelude::*;

include_forces!("forces/mistake.rs");

fn main() {}
