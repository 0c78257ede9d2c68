//! What a command is to work on: force files, read, checked and compiled together.

use super::{Failure, Input, Progress, colour, complain};
use crate::diagnostic::Diagnostics;
use crate::files::{self, Unit};
use crate::syntax;

impl Input {
    /// Reads, checks and compiles everything asked for. Warnings are printed, errors of all files collected.
    pub(super) fn compile(&self) -> Result<Vec<Unit>, Failure> {
        if self.search.outputs.is_some() && self.search.layout.row().computes.is_some() {
            let name = self.search.layout.row().name;
            return Err(Failure::Input(format!(
                "error: the layout `{name}` says itself what is computed\n  = help: leave `--outputs` out"
            )));
        }
        let request = self.search.request();
        if let Some(error) = request.impossible() {
            return Err(Failure::Input(error));
        }
        let found = files::read_all(&self.paths);
        let mut errors = found.errors;
        let progress = Progress::new(found.sources.len());
        let wanted = |name: &str| self.only.is_empty() || self.only.iter().any(|only| only == name);
        let (units, wrong) =
            files::compile_all(found.sources, &wanted, &request, &mut |name| progress.step(name));
        errors.extend(wrong.iter().map(|diagnostics| diagnostics.render(colour())));
        drop(progress);
        for unit in &units {
            let warnings = Diagnostics::new(unit.compiled.source.clone(), unit.compiled.warnings.clone());
            if !warnings.list.is_empty() {
                complain(&(warnings.render(colour()) + "\n"));
            }
        }
        if errors.is_empty() {
            errors.extend(files::duplicates(&units));
            errors.extend(self.unknown_names(&units));
            errors.extend(files::unknown(&units, &request.known));
        }
        if errors.is_empty() { Ok(units) } else { Err(Failure::Input(errors.join("\n\n"))) }
    }

    /// Names that were asked for and are not there.
    fn unknown_names(&self, units: &[Unit]) -> Vec<String> {
        let names: Vec<&str> =
            units.iter().flat_map(|unit| unit.compiled.names.iter().map(String::as_str)).collect();
        let unknown = self.only.iter().filter(|only| !names.contains(&only.as_str()));
        unknown
            .map(|only| {
                let near = syntax::suggest::did_you_mean(only, names.iter().copied());
                let help = near.unwrap_or_else(|| "`forcec stats` lists the force functions".to_owned());
                format!("error: no force function `{only}`\n  = help: {help}")
            })
            .collect()
    }
}
