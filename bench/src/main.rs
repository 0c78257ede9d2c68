//! `cargo run --release -p forcec-bench -- run SCENE`, `… -- catalogue` and the like: scenes through time, how stable they are,
//! and the tables of the documents.

use clap::{Parser, Subcommand};
use forcec_bench::catalogue::{self, CASES};
use forcec_bench::document::{self, document};
use forcec_bench::run::{self, Options};
use forcec_bench::{in_folder, modes, work_precision, write, yardsticks};
use std::path::PathBuf;
use std::process::ExitCode;

/// Scenes through time, and how stable they are.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Steps a scene and reports on a line.
    Run(Options),
    /// Run time per simulated second against the final error, one curve per integrator, compared with peers.
    WorkPrecision(work_precision::Options),
    /// Times every kernel in every mode against its error.
    Modes {
        /// Names of kernels; all if there are none.
        kernels: Vec<String>,
        /// How often each is timed.
        #[arg(long, default_value_t = 21)]
        rounds: usize,
        /// Writes a row a kernel and mode.
        #[arg(long, value_name = "FILE")]
        csv: Option<PathBuf>,
    },
    /// Tries the cases of the stability catalogue and prints a table.
    Catalogue {
        /// Numbers of cases; all if there are none.
        cases: Vec<usize>,
        /// Shorter times and fewer steps, where a case has them.
        #[arg(long)]
        quick: bool,
    },
    /// Mechanisms of rigid joints against published solutions, and robots that fall.
    Yardsticks {
        /// One method a mechanism.
        #[arg(long)]
        quick: bool,
    },
    /// Measures the tables of the documents and prints them between their marks.
    Document(document::Options),
}

/// The exit code of a command that may fail.
fn done(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Run(options) => done(run::run(&options)),
        Command::Document(options) => done(document(&options)),
        Command::Yardsticks { quick } => {
            println!("{}", yardsticks::table(quick));
            ExitCode::SUCCESS
        }
        Command::WorkPrecision(options) => done(work_precision::run(&options)),
        Command::Modes { kernels, rounds, csv } => {
            let only: Vec<&str> = kernels.iter().map(String::as_str).collect();
            let written = in_folder("modes", |folder| {
                let points = modes::measure(&only, rounds, folder);
                println!("{}", modes::table(&points));
                csv.map_or(Ok(()), |path| write(&path, &modes::csv(&points)))
            });
            done(written.and_then(|written| written))
        }
        Command::Catalogue { cases, quick } => {
            let chosen = CASES.iter().filter(|case| cases.is_empty() || cases.contains(&case.number));
            println!("{}", catalogue::HEAD);
            let mut failed = false;
            for case in chosen {
                let verdict = (case.run)(quick);
                failed |= !verdict.passes;
                println!("{}", catalogue::row(case, &verdict));
            }
            ExitCode::from(u8::from(failed))
        }
    }
}
