//! How compile time grows with a kernel: chains of helper functions that make about 1e4, 1e5 and 1e6 nodes.
//!
//!     cargo run --release -p forcec-bench --bin growth

use forcec_bench::{chain, compile_all, nodes};
use std::time::Instant;

fn main() {
    println!("| nodes | seconds | µs a node |\n|--:|--:|--:|");
    for links in [220, 2200, 22_000] {
        let source = chain(links);
        let started = Instant::now();
        let compiled = compile_all(&source);
        let (seconds, nodes) = (started.elapsed().as_secs_f64(), nodes(&compiled));
        println!("| {nodes} | {seconds:.2} | {:.1} |", seconds * 1e6 / nodes as f64);
    }
}
