//! `forcec lint`: reports how force functions behave in a solver, and suggests alternatives.

use crate::cli::input::{Files, warn};
use crate::cli::options::{KNOWN, Options};
use crate::cli::{Failure, Outcome, in_parallel, print};
use crate::lint::{advise, render};
use crate::options::plan::Effort;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Lint {
    /// Force files, or folders that are searched for them
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,
    /// Only the force function of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    #[command(flatten)]
    options: Options<KNOWN>,
    /// Exit 1 if there is a warning
    #[arg(long)]
    deny_warnings: bool,
}

impl Lint {
    pub(super) fn run(self) -> Outcome {
        let mut request = self.options.request();
        request.plan.effort = Effort::Quick;
        let files = Files { paths: &self.paths, only: &self.only };
        // The report below includes the compiler's warnings, with measurements.
        let units = files.compile(&request, &|_| ())?;
        let units: Vec<_> = units.iter().map(|unit| &unit.compiled).collect();
        let functions: Vec<_> =
            units.iter().flat_map(|unit| &unit.functions).map(|f| &f.definition).collect();
        let all = in_parallel(&functions, |definition| &definition.name, |definition| advise(definition));
        let mut all = all.into_iter();
        let mut warned = false;
        for unit in units {
            for advice in all.by_ref().take(unit.functions.len()) {
                print(&(render(&advice, &unit.source) + "\n"))?;
                warn(&unit.source, &advice.warnings);
                warned |= !advice.warnings.is_empty();
            }
        }
        if warned && self.deny_warnings { Err(Failure::Check) } else { Ok(()) }
    }
}
