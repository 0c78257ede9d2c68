use forcec_runtime::prelude::*;

include_forces!("forces/nothing.rs");

fn main() {}
