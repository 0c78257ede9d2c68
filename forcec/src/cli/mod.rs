//! The command line: a thin door onto the library.
//!
//! In: arguments. Out: files, tables, messages, and an exit code: 0 done, 1 a check failed, 2 bad usage or bad input.

mod build;
mod check;
mod input;
mod rounding;
mod show;
mod stats;

use crate::compile::Request;
use crate::exact::Exact;
use crate::kernel::{Precision, Target};
use crate::layouts::{LANES, Layout};
use crate::optimize::{LOWER, PASSES};
use crate::outputs::Part;
use crate::plan::{Effort, Mode, Plan};
use crate::specialize::Specialization;
use clap::{CommandFactory, Parser, Subcommand};
use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  forcec build joints.rs --out kernels               C kernels in double precision
  forcec build forces/ --out src/kernels --target rust --real f64 --real f32
  forcec build forces/ --out kernels --check         exit 1 if the files on disk are not these
  forcec check forces/                               compare every kernel with its mathematics
  forcec show joints.rs hinge --stage derivative     what the blocks of the hinge are
  forcec stats forces/                               operations, lines and compile time";

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
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
    /// Only the force function of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    #[command(flatten)]
    search: Search,
}

/// How to make kernels.
#[derive(clap::Args)]
struct Search {
    /// How long to look for fewer operations
    #[arg(long, value_parser = effort, default_value = "default", value_name = "quick|default|max")]
    effort: Effort,
    /// What kernels may do to rounding
    #[arg(long, value_parser = mode, default_value = "balanced", value_name = "strict|balanced|fast|accurate")]
    mode: Mode,
    /// Write products that are added as fused multiplications and additions
    #[arg(long)]
    fma: bool,
    /// Only these passes of the optimiser, in their own order
    #[arg(long, value_name = "PASS,…", value_delimiter = ',', value_parser = pass)]
    passes: Option<Vec<u32>>,
    /// What kernels compute, of value, jacobian, force, dfdx and dfdv; `value` is C, or E, and its rate
    #[arg(long, value_name = "OUTPUT,…", value_delimiter = ',', value_parser = output)]
    outputs: Option<Vec<&'static [Part]>>,
    /// Where results stand: `dense`, `packed`, `system` or `product`
    #[arg(long, value_parser = layout, default_value = "dense", value_name = "LAYOUT")]
    layout: Layout,
    /// How many instances a kernel computes at once, from structures of arrays
    #[arg(long, value_parser = lanes, default_value = "1", value_name = "1|4|8")]
    lanes: usize,
    /// A body that never moves: it has no velocity, no degrees of freedom, and feels no force; may be repeated
    #[arg(long, value_name = "BODY")]
    fixed: Vec<String>,
    /// A parameter whose value is known, as in `damping=0` or `arm_b=[0,0,0.5]`; may be repeated
    #[arg(long, value_parser = Specialization::parse_value, value_name = "NAME=VALUE")]
    set: Vec<(String, Vec<Exact>)>,
}

impl Search {
    fn request(&self) -> Request {
        let mut plan = Plan { mode: self.mode, fma: self.fma, ..Plan::from(self.effort) };
        if let Some(passes) = &self.passes {
            plan.passes = passes.iter().fold(0, |all, pass| all | pass);
        }
        let known = Specialization { fixed: self.fixed.clone(), set: self.set.clone() };
        let outputs = match &self.outputs {
            Some(chosen) => Part::in_order(chosen.concat()),
            None => Part::DEFAULT.to_vec(),
        };
        Request { plan, known, outputs, layout: self.layout, lanes: self.lanes }
    }
}

/// The layout of this name.
fn layout(name: &str) -> Result<Layout, String> {
    Layout::named(name).ok_or_else(|| format!("the layouts are {}", Layout::names()))
}

/// So many lanes.
fn lanes(text: &str) -> Result<usize, String> {
    let found = LANES.iter().find(|lanes| lanes.to_string() == text);
    found.copied().ok_or_else(|| format!("lanes are {LANES:?}"))
}

/// The mode of this name.
fn mode(name: &str) -> Result<Mode, String> {
    Mode::named(name).ok_or_else(|| format!("the modes are {}", Mode::names()))
}

/// What an output of this name stands for.
fn output(name: &str) -> Result<&'static [Part], String> {
    let found = Part::CHOICES.iter().find(|(own, _)| *own == name);
    found.map(|(_, parts)| *parts).ok_or_else(|| {
        let names: Vec<&str> = Part::CHOICES.iter().map(|(name, _)| *name).collect();
        format!("the outputs are {}", names.join(", "))
    })
}

/// The pass of this name, as a plan has it.
fn pass(name: &str) -> Result<u32, String> {
    let plan = Plan::default().with_passes([name]);
    plan.map(|plan| plan.passes).map_err(|_| {
        let names: Vec<&str> = [LOWER].into_iter().chain(PASSES.iter().map(|pass| pass.name)).collect();
        format!("the passes are {}", names.join(", "))
    })
}

/// The effort of this name.
fn effort(name: &str) -> Result<Effort, String> {
    let found = Effort::ALL.into_iter().find(|(own, _)| *own == name);
    found.map(|(_, effort)| effort).ok_or_else(|| "it is one of `quick`, `default` and `max`".to_owned())
}

/// Why a command did not end well.
enum Failure {
    /// A check failed: exit code 1. What is wrong has been printed.
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
            let code = if error.use_stderr() { 2 } else { 0 };
            // A closed pipe is no reason to complain about.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let outcome = match arguments.command {
        Command::Build(build) => build.run(),
        Command::Check(check) => check.run(),
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

/// Prints to standard output; a reader that has gone away ends the program quietly.
fn print(text: &str) -> Outcome {
    let mut out = std::io::stdout();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Input(format!("error: cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a line to standard error, whether or not somebody still reads it.
fn complain(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Whether messages may be coloured: only on a terminal, and never under `NO_COLOR`.
fn colour() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
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

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum TargetArgument {
    /// C99: NAME.h, NAME.c and forcec.h
    C,
    /// Rust: NAME.rs
    Rust,
}

impl From<TargetArgument> for Target {
    fn from(argument: TargetArgument) -> Target {
        match argument {
            TargetArgument::C => Target::C,
            TargetArgument::Rust => Target::Rust,
        }
    }
}

#[derive(clap::ValueEnum, Clone, Copy, PartialEq, Eq)]
enum RealArgument {
    /// double precision
    F64,
    /// single precision
    F32,
}

impl From<RealArgument> for Precision {
    fn from(argument: RealArgument) -> Precision {
        match argument {
            RealArgument::F64 => Precision::F64,
            RealArgument::F32 => Precision::F32,
        }
    }
}
