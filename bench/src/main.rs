//! `cargo run --release -p forcec-bench -- run SCENE` and `… -- catalogue`: scenes through time, and how stable they are.

use clap::{Parser, Subcommand};
use forcec_bench::catalogue::{self, CASES};
use forcec_bench::run::{self, Options};
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
    /// Tries the cases of the stability catalogue and prints a table.
    Catalogue {
        /// Numbers of cases; all if there are none.
        cases: Vec<usize>,
        /// Shorter times and fewer steps, where a case has them.
        #[arg(long)]
        quick: bool,
    },
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Run(options) => match run::run(&options) {
            Ok(()) => ExitCode::SUCCESS,
            Err(message) => {
                eprintln!("error: {message}");
                ExitCode::from(2)
            }
        },
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
