//! The compile time is proportional to the number of nodes: `cargo test -p forcec-bench --release -- --nocapture` prints it.

use forcec_bench::{chain, compile_all, nodes};
use std::time::{Duration, Instant};

/// Number of nodes, and compile time.
fn measure(links: usize) -> (usize, Duration) {
    let source = chain(links);
    let started = now();
    let compiled = compile_all(&source);
    let (time, nodes) = (now() - started, nodes(&compiled));
    let each = time.as_secs_f64() * 1e6 / nodes as f64;
    println!("{links} links: {nodes} nodes, {time:.2?}, {each:.1} µs a node");
    (nodes, time)
}

/// The processor time of this process, over all threads, so that a busy machine does not fail the test; wall
/// time where the system does not report processor time.
fn now() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let wall = START.get_or_init(Instant::now).elapsed();
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name, which may contain spaces: the 12th and 13th fields, in hundredths of a second.
    let fields = stat.rsplit_once(") ").map_or("", |(_, fields)| fields).split(' ').skip(11).take(2);
    match fields.map(str::parse::<u64>).collect::<Result<Vec<u64>, _>>() {
        Ok(ticks) if ticks.len() == 2 => Duration::from_millis(10 * ticks.iter().sum::<u64>()),
        _ => wall,
    }
}

#[test]
fn time_per_node_does_not_grow() {
    // In turn, the fastest of each size: other processes that empty the caches slow the larger kernel more.
    let mut fastest = [(0, Duration::MAX); 2];
    for _ in 0..3 {
        for (best, links) in fastest.iter_mut().zip([220, 2200]) {
            let (nodes, time) = measure(links);
            *best = (nodes, best.1.min(time));
        }
    }
    let [(few, short), (many, long)] = fastest;
    let growth = (long.as_secs_f64() / many as f64) / (short.as_secs_f64() / few as f64);
    println!("time a node grows {growth:.2} times");
    assert!(many > 5 * few, "{few} and {many} nodes");
    assert!(growth < 2.0, "time a node grows {growth:.2} times from {few} to {many} nodes");
}
