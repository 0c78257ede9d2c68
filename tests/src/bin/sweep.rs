//! The whole covering array: `cargo run --release -p forcec-tests --bin sweep`, optionally followed by a part
//! of the names of functions. Failures are printed, and their folders below `target/sweep` stay.

use forcec_tests::sweep::{failures, rows, subjects};
use std::process::ExitCode;

fn main() -> ExitCode {
    let parts: Vec<String> = std::env::args().skip(1).collect();
    let wanted =
        |name: &str, _: usize| parts.is_empty() || parts.iter().any(|part| name.contains(part.as_str()));
    let subjects = subjects(&["../constraints", "unseen", "cases"], &wanted);
    let rows = rows(&subjects, true);
    println!("{} functions, {} rows", subjects.len(), rows.len());
    let count = rows.len();
    let base = std::env::current_dir().expect("there is a folder").join("target/sweep");
    let failures = failures(rows, &base.to_string_lossy());
    println!("{} of {count} rows fail", failures.len());
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
