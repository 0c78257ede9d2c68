use forcec_runtime::prelude::*;

#[energy]
struct Spring;

fn main() {}
