//! Compiling takes time in proportion to the kernel: `cargo test -p forcec-bench --release -- --nocapture` prints it.

use forcec_bench::{chain, compile_all, nodes};
use std::time::{Duration, Instant};

/// Nodes, and the fastest of a few runs: the others shared the machine with somebody.
fn measure(links: usize) -> (usize, Duration) {
    let source = chain(links);
    let run = || {
        let started = Instant::now();
        let compiled = compile_all(&source);
        (started.elapsed(), nodes(&compiled))
    };
    let runs = [run(), run(), run()];
    let (time, nodes) = runs.into_iter().min().expect("three runs");
    println!(
        "{links} links: {nodes} nodes, {time:.0?}, {:.2} µs a node",
        time.as_secs_f64() * 1e6 / nodes as f64
    );
    (nodes, time)
}

#[test]
#[cfg_attr(debug_assertions, ignore = "measures the optimised build")]
fn time_per_node_does_not_grow() {
    let (few, short) = measure(220);
    let (many, long) = measure(2200);
    let growth = (long.as_secs_f64() / many as f64) / (short.as_secs_f64() / few as f64);
    println!("time a node grows {growth:.2} times");
    assert!(many > 5 * few, "{few} and {many} nodes");
    assert!(growth < 2.0, "time a node grows {growth:.2} times from {few} to {many} nodes");
}
