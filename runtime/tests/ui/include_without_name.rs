use forcec_runtime::prelude::*;

include_forces!("forces/two-words.rs");

fn main() {}
