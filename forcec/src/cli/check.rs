//! `forcec check`: every kernel against the mathematics of its source.

use super::{Failure, Input, Outcome, Progress, print};
use crate::outputs::Part;
use crate::verify::{self, CheckOptions, Report, Subject};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

#[derive(clap::Args)]
pub(super) struct Check {
    #[command(flatten)]
    input: Input,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
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
                        let report = check(&subject, &options);
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
        print(&if self.json { verify::json(&reports) } else { verify::table(&reports) })?;
        if reports.iter().all(|report| report.passed) { Ok(()) } else { Err(Failure::Check) }
    }
}
