use forcec_runtime::prelude::*;

include_forces!("nowhere.rs");

fn main() {}
