//! `forcec check`: every kernel against the mathematics of its source.

use super::{Failure, Input, Outcome, Progress, print, rounding};
use crate::compile::Stages;
use crate::kernel::Kernel;
use crate::layouts::Layout;
use crate::outputs::Part;
use crate::verify::probe::Probe;
use crate::verify::{self, CheckOptions, Family, Report, Subject};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

#[derive(clap::Args)]
pub(super) struct Check {
    #[command(flatten)]
    input: Input,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Print bounds of the rounding errors of each result beside the errors, in both precisions
    #[arg(long)]
    rounding: bool,
}

impl Check {
    pub(super) fn run(self) -> Outcome {
        let units = self.input.compile()?;
        let functions: Vec<_> = units.iter().flat_map(|unit| &unit.compiled.functions).collect();
        let progress = Progress::new(functions.len());
        let next = AtomicUsize::new(0);
        let reports: Mutex<Vec<(usize, Report)>> = Mutex::new(Vec::new());
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(functions.len().max(1));
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        let Some(function) = functions.get(index) else { break };
                        let subject = Subject { source: &function.source, program: &function.program };
                        let options = CheckOptions::default();
                        let whole = function.outputs() == Part::DEFAULT;
                        let check = if whole { verify::check } else { verify::check_chosen };
                        let mut report = check(&subject, &options);
                        let misplaced = misplaced(function, &subject);
                        report.passed &= misplaced.is_none();
                        report.problems.extend(misplaced);
                        progress.step(&function.kernel.name);
                        reports.lock().unwrap_or_else(PoisonError::into_inner).push((index, report));
                    }
                });
            }
        });
        drop(progress);
        let mut reports = reports.into_inner().unwrap_or_else(PoisonError::into_inner);
        reports.sort_by_key(|(index, _)| *index);
        let reports: Vec<Report> = reports.into_iter().map(|(_, report)| report).collect();
        let kernels: Vec<&Kernel> = functions.iter().map(|function| &function.kernel).collect();
        print(&match (self.json, self.rounding) {
            (true, false) => verify::json(&reports),
            (true, true) => with_rounding(&verify::json(&reports), &kernels),
            (false, false) => verify::table(&reports),
            (false, true) => format!("{}\n{}", verify::table(&reports), rounding::table(&kernels)),
        })?;
        if reports.iter().all(|report| report.passed) { Ok(()) } else { Err(Failure::Check) }
    }
}

/// A report as JSON with one more field, `rounding`.
fn with_rounding(report: &str, kernels: &[&Kernel]) -> String {
    let mut report: serde_json::Value = serde_json::from_str(report).expect("a report is JSON");
    report["rounding"] = rounding::json(kernels);
    format!("{report}\n")
}

/// States at which places are compared.
const STATES: usize = 8;

/// What is wrong with the statements of a kernel that lays its results out otherwise: they must compute what the program
/// does, which has been checked, and put it where it belongs.
fn misplaced(function: &Stages, subject: &Subject) -> Option<String> {
    /// Statements may round in another order than the program.
    const SLACK: f64 = 4.0;
    let kernel = &function.kernel;
    if (kernel.layout, kernel.lanes) == (Layout::Dense, 1) {
        return None;
    }
    let probe = Probe::new(subject);
    for state in 0..STATES {
        let inputs = probe.draw(Family::Random, 1, state);
        let (expected, bounds) = (probe.program(&inputs), probe.bounds(&inputs));
        let Some(found) = kernel.schedule.evaluate(&|slot| probe.input(&inputs, slot)) else {
            return Some("an entry is never written".to_owned());
        };
        let list: Vec<f64> = found.iter().copied().collect();
        let found = kernel.packing.as_ref().map_or(list.clone(), |packing| packing.unpack(&list, &0.0));
        for (entry, ((x, y), bound)) in expected.iter().zip(&found).zip(bounds).enumerate() {
            let apart = (x - y).abs();
            if x.is_finite() && (apart.is_nan() || apart > SLACK * bound + f64::MIN_POSITIVE) {
                return Some(format!("{} is {y:e} where it belongs, not {x:e}", probe.name(entry).1));
            }
        }
    }
    None
}
