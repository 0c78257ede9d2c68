//! `cargo run --release -p forcec-bench --bin layouts [KERNEL] [ROUNDS]`: how long the layouts of a kernel that is written
//! by hand take beside it, an instance.

use forcec_bench::kernels::{BY_HAND, FLAGS, RUST_FLAGS};
use forcec_bench::layouts::{measure, table};
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let kernel = arguments.next().unwrap_or_else(|| BY_HAND[0].to_owned());
    let rounds = arguments.next().map_or(Some(201), |rounds| rounds.parse().ok());
    let (true, Some(rounds @ 1..)) = (BY_HAND.contains(&kernel.as_str()), rounds) else {
        eprintln!("usage: layouts [{}] [ROUNDS]", BY_HAND.join("|"));
        return ExitCode::from(2);
    };
    let folder = std::env::temp_dir().join(format!("forcec-layouts-{}", std::process::id()));
    let rows = measure(&kernel, rounds, &folder);
    if let Err(error) = std::fs::remove_dir_all(&folder) {
        eprintln!("{}: {error}", folder.display());
    }
    println!("`{kernel}`, gcc {FLAGS}; rustc {RUST_FLAGS}; {rounds} rounds\n");
    print!("{}", table(&rows));
    ExitCode::SUCCESS
}
