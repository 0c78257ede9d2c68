//! `cargo run --release -p forcec-bench -- run SCENE` and `… -- catalogue`: scenes through time, and how stable they are.

use clap::{Parser, Subcommand};
use forcec_bench::catalogue::{self, CASES};
use forcec_bench::precision::{self, PROBLEMS, STEPS};
use forcec_bench::run::{self, Options};
use forcec_bench::work_precision;
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
    /// Run time against error, a row an integrator and a step.
    Precision {
        /// Names of problems, c10 or ben25; all if there are none.
        problems: Vec<String>,
        /// Steps of 1/60 and 1/120 s alone.
        #[arg(long)]
        quick: bool,
    },
    /// Time of a simulated second against error at the end, a curve an integrator, beside peers.
    WorkPrecision(work_precision::Options),
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
        Command::Run(options) => answer(run::run(&options)),
        Command::WorkPrecision(options) => answer(work_precision::run(&options)),
        Command::Precision { problems, quick } => {
            let chosen = |name: &str| problems.is_empty() || problems.iter().any(|own| own == name);
            let steps = if quick { &STEPS[1..3] } else { &STEPS[..] };
            for problem in PROBLEMS.iter().filter(|problem| chosen(problem.name)) {
                let (points, own) = precision::measure(problem, steps);
                println!("{}", precision::table(problem, &points, own));
            }
            ExitCode::SUCCESS
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

fn answer(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}
