use forcec_runtime::prelude::*;

include_forces!(nowhere);

fn main() {}
