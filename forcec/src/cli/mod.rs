//! The command line, a thin layer over the library.
//!
//! In: arguments. Out: files, tables, messages, and an exit code: 0 success, 1 check failed, 2 bad usage or
//! input.

mod build;
mod check;
mod input;
mod lint;
mod options;
mod rounding;
mod show;
mod stats;

use crate::optimize::{LOWER, PASSES};
use crate::options::Request;
use crate::options::plan::Plan;
use clap::{CommandFactory, Parser, Subcommand};
use options::Options;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

const EXAMPLES: &str = "\
Examples:
  forcec build joints.rs --out kernels               C kernels in double precision
  forcec build forces/ --out src/kernels --target rust --real f64 --real f32
  forcec build forces/ --out kernels --check         exit 1 if the files on disk are not these
  forcec check forces/                               compare every kernel with its mathematics
  forcec lint forces/                                how functions behave in a solver
  forcec show joints.rs hinge --stage derivative     what the blocks of the hinge are
  forcec stats forces/                               operations, lines and compile time
  forcec build --scene robot.toml                    exactly the kernels that a scene needs";

/// An offline force compiler: constraints, energies and forces to C and Rust kernels with exact derivatives.
#[derive(Parser)]
#[command(name = "forcec", version, about, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compile force files to kernels
    #[command(
        after_help = "Example:\n  forcec build joints.rs --out kernels --target c --real f64 --real f32"
    )]
    Build(build::Build),
    /// Compare kernels with the mathematics of their source
    #[command(after_help = "Example:\n  forcec check forces/ --only hinge")]
    Check(check::Check),
    /// Advise on formulations: nonlinear, singular, badly damped, unstable at which step
    #[command(after_help = "Example:\n  forcec lint forces/ --only distance --deny-warnings")]
    Lint(lint::Lint),
    /// Print one stage of one force function
    #[command(after_help = "Example:\n  forcec show joints.rs hinge --stage latex")]
    Show(show::Show),
    /// Print operations, lines, non-zeros and compile time of every kernel
    #[command(after_help = "Example:\n  forcec stats forces/ --json")]
    Stats(stats::Stats),
    /// Print a completion script for a shell
    #[command(after_help = "Example:\n  forcec completions bash > /etc/bash_completion.d/forcec")]
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// Where force functions come from.
#[derive(clap::Args)]
struct Input {
    /// Force files, or folders that are searched for them
    #[arg(value_name = "PATH", required_unless_present = "scene")]
    paths: Vec<PathBuf>,
    /// A scene file: it names the force files, the kernels and how they are made
    #[arg(long, value_name = "FILE", conflicts_with = "paths")]
    scene: Option<PathBuf>,
    /// Only the force function of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    #[command(flatten)]
    search: Search,
}

/// How to make kernels.
#[derive(clap::Args)]
struct Search {
    #[command(flatten)]
    options: Options,
    /// Only these passes of the optimiser, in their own order
    #[arg(long, value_name = "PASS,…", value_delimiter = ',', value_parser = pass)]
    passes: Option<Vec<u32>>,
}

impl Search {
    fn request(&self) -> Request {
        let mut request = self.options.request();
        if let Some(passes) = &self.passes {
            request.plan.passes = passes.iter().fold(0, |all, pass| all | pass);
        }
        request
    }
}

/// The pass with this name, as a bit of a plan.
fn pass(name: &str) -> Result<u32, String> {
    let plan = Plan::default().with_passes([name]);
    plan.map(|plan| plan.passes).map_err(|_| {
        let names: Vec<&str> = [LOWER].into_iter().chain(PASSES.iter().map(|pass| pass.name)).collect();
        format!("the passes are {}", names.join(", "))
    })
}

/// Why a command failed.
enum Failure {
    /// A check failed: exit code 1. The failure has been printed.
    Check,
    /// Bad usage or bad input: exit code 2.
    Input(String),
}

type Outcome = Result<(), Failure>;

/// Runs the command line on the process's arguments.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let printed = error.print().and_then(|()| std::io::stdout().flush());
            return match (error.use_stderr(), unless_closed(printed)) {
                (false, Ok(())) => ExitCode::SUCCESS,
                (false, Err(Failure::Input(message))) => {
                    complain(&message);
                    ExitCode::from(2)
                }
                _ => ExitCode::from(2),
            };
        }
    };
    let outcome = match arguments.command {
        Command::Build(build) => build.run(),
        Command::Check(check) => check.run(),
        Command::Lint(lint) => lint.run(),
        Command::Show(show) => show.run(),
        Command::Stats(stats) => stats.run(),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "forcec", &mut script);
            print(&String::from_utf8_lossy(&script))
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Check) => ExitCode::from(1),
        Err(Failure::Input(message)) => {
            complain(&message);
            ExitCode::from(2)
        }
    }
}

/// Prints to standard output; a closed pipe ends the program quietly.
fn print(text: &str) -> Outcome {
    let mut out = std::io::stdout();
    unless_closed(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// The result of printing; a closed pipe is not an error.
fn unless_closed(printed: std::io::Result<()>) -> Outcome {
    match printed {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Input(format!("error: cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a line to standard error; ignores errors.
fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Whether messages may be coloured: on a terminal only, and never under `NO_COLOR`.
fn colour() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

/// Runs `work` on each item, on all processors, with a progress line; returns the results in order.
fn in_parallel<T: Sync, R: Send>(
    items: &[T],
    name: impl Fn(&T) -> &str + Sync,
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let progress = Progress::new(items.len());
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(items.len().max(1));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { break };
                    let result = work(item);
                    progress.step(name(item));
                    results.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// A progress line on a terminal, once the work takes longer than a second.
struct Progress {
    bar: indicatif::ProgressBar,
    started: std::time::Instant,
}

impl Progress {
    fn new(steps: usize) -> Progress {
        let bar = indicatif::ProgressBar::with_draw_target(
            Some(steps as u64),
            indicatif::ProgressDrawTarget::hidden(),
        );
        if let Ok(style) = indicatif::ProgressStyle::with_template("{pos}/{len} {wide_msg}") {
            bar.set_style(style);
        }
        Progress { bar, started: std::time::Instant::now() }
    }

    fn step(&self, name: &str) {
        let late = self.started.elapsed().as_secs() >= 1;
        if late && self.bar.is_hidden() && std::io::stderr().is_terminal() {
            self.bar.set_draw_target(indicatif::ProgressDrawTarget::stderr());
        }
        self.bar.set_message(name.to_owned());
        self.bar.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
