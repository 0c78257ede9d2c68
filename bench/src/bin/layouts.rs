//! `cargo run --release -p forcec-bench --bin layouts [KERNEL] [ROUNDS]`: run times per instance of the
//! layouts of a kernel, compared with the hand-written kernel.

use forcec_bench::in_folder;
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
    let printed = in_folder("layouts", |folder| {
        let rows = measure(&kernel, rounds, folder);
        println!("`{kernel}`, gcc {FLAGS}; rustc {RUST_FLAGS}; {rounds} rounds\n");
        print!("{}", table(&rows));
    });
    if let Err(error) = printed {
        eprintln!("{error}");
    }
    ExitCode::SUCCESS
}
