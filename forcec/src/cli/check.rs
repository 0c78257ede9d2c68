//! `forcec check`: compares every kernel with the mathematics of its source.

use crate::cli::options::{Options, REAL};
use crate::cli::{Failure, Input, Outcome, in_parallel, print, rounding};
use crate::compile::{Request, Stages};
use crate::kernel::Kernel;
use crate::layout::{Lanes, Layout};
use crate::math::number::Precision;
use crate::model::bodies::Slot;
use crate::model::outputs::Part;
use crate::verify::probe::Probe;
use crate::verify::{self, CheckOptions, Family, Printed, Report, Subject};

#[derive(clap::Args)]
pub(super) struct Check {
    #[command(flatten)]
    input: Input,
    #[command(flatten)]
    printed: Options<REAL>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Print bounds of the rounding errors of each output next to the errors, in both precisions
    #[arg(long)]
    rounding: bool,
    /// Pass although an arm of a branch was active at no state
    #[arg(long)]
    allow_uncovered: bool,
    /// Exit 1 if there is a warning, before anything is compared
    #[arg(long)]
    deny_warnings: bool,
}

impl Check {
    pub(super) fn run(self) -> Outcome {
        let (units, scene) = match &self.input.scene {
            Some(path) => {
                let scene = self.input.scene(path, self.deny_warnings)?;
                (scene.units, scene.request)
            }
            None => (self.input.compile(self.deny_warnings)?, Request::default()),
        };
        let precisions = scene.with(&self.printed.0).precisions_or_double();
        let compiled = units.iter().map(|unit| &unit.compiled);
        let functions: Vec<_> = compiled
            .flat_map(|file| file.functions.iter().map(move |function| (function, &file.source)))
            .collect();
        let reports: Vec<Report> = in_parallel(
            &functions,
            |(function, _)| &function.kernel.name,
            |&(function, source)| {
                let subject = Subject { source: &function.source, program: &function.program };
                let options = CheckOptions::default();
                let whole = function.outputs() == Part::DEFAULT;
                let check = if whole { verify::check_printed } else { verify::check_chosen };
                let kernel = &function.kernel;
                let double = |inputs: &dyn Fn(Slot) -> f64| kernel.evaluate::<f64>(inputs);
                let single = |inputs: &dyn Fn(Slot) -> f64| {
                    let results = kernel.evaluate::<f32>(&|slot| inputs(slot) as f32)?;
                    Some(results.into_iter().map(f64::from).collect())
                };
                let printed = precisions.iter().map(|&precision| match precision {
                    Precision::F64 => Printed { precision, evaluate: &double },
                    Precision::F32 => Printed { precision, evaluate: &single },
                });
                let mut report = check(&subject, &printed.collect::<Vec<Printed>>(), &options);
                report.kernel.clone_from(&function.kernel.name);
                for branch in &mut report.branches {
                    branch.line = branch.span.map(|span| source.line_column(span.start).0);
                }
                let misplaced = misplaced(function, &subject);
                report.passed &= misplaced.is_none();
                report.problems.extend(misplaced);
                report
            },
        );
        let kernels: Vec<&Kernel> = functions.iter().map(|(function, _)| &function.kernel).collect();
        print(&match (self.json, self.rounding) {
            (true, false) => verify::json(&reports),
            (true, true) => with_rounding(&verify::json(&reports), &kernels),
            (false, false) => verify::table(&reports),
            (false, true) => format!("{}\n{}", verify::table(&reports), rounding::table(&kernels)),
        })?;
        let covers = |report: &Report| self.allow_uncovered || report.covers_branches();
        if reports.iter().all(|report| report.passed && covers(report)) {
            Ok(())
        } else {
            Err(Failure::Check)
        }
    }
}

/// Adds a field `rounding` to a JSON report.
fn with_rounding(report: &str, kernels: &[&Kernel]) -> String {
    let mut report: serde_json::Value = serde_json::from_str(report).expect("a report is JSON");
    report["rounding"] = rounding::json(kernels);
    format!("{report}\n")
}

/// The number of states at which positions of outputs are compared.
const STATES: usize = 8;

/// An error if the statements of a kernel in another layout do not give the checked program's outputs.
fn misplaced(function: &Stages, subject: &Subject) -> Option<String> {
    /// Statements may round in another order than the program.
    const SLACK: f64 = 4.0;
    let kernel = &function.kernel;
    if (kernel.layout, kernel.lanes) == (Layout::Dense, Lanes::One) && kernel.once().is_none() {
        return None;
    }
    let probe = Probe::new(subject);
    for state in 0..STATES {
        let inputs = probe.draw(Family::Random, 1, state);
        let (expected, bounds) = (probe.program(&inputs), probe.bounds(&inputs));
        let Some(found) = kernel.evaluate(&|slot| probe.input(&inputs, slot)) else {
            return Some("an entry is never written".to_owned());
        };
        for (entry, ((x, y), bound)) in expected.iter().zip(&found).zip(bounds).enumerate() {
            let apart = (x - y).abs();
            if x.is_finite() && (apart.is_nan() || apart > SLACK * bound + f64::MIN_POSITIVE) {
                return Some(format!("{} is {y:e} where it belongs, not {x:e}", probe.name(entry).1));
            }
        }
    }
    None
}
