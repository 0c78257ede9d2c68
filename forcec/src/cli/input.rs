//! Reads, checks and compiles the force files that a command works on.

use crate::cli::{Failure, Input, Progress, Search, colour, complain};
use crate::compile::Request;
use crate::driver::files::{self, Unit};
use crate::driver::scene::{self, Listener, Scene};
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::Source;
use crate::source::suggest;
use std::path::{Path, PathBuf};

impl Input {
    /// Compiles the inputs of a command. Prints warnings, or fails if denied; collects the errors of all
    /// files.
    pub(super) fn compile(&self, deny_warnings: bool) -> Result<Vec<Unit>, Failure> {
        if let Some(path) = &self.scene {
            return self.scene(path, deny_warnings).map(|scene| scene.units);
        }
        let request = self.search.request();
        if let Some((message, help)) = request.conflict() {
            return Err(Failure::Input(format!("error: {message}\n  = help: {help}")));
        }
        let files = Files { paths: &self.paths, only: &self.only };
        let units = files.compile(&request, &|unit| warn(&unit.compiled.source, &unit.compiled.warnings))?;
        let warned = units.iter().any(|unit| !unit.compiled.warnings.is_empty());
        if warned && deny_warnings { Err(Failure::Check) } else { Ok(units) }
    }

    /// Compiles a scene, which specifies its options itself.
    pub(super) fn scene(&self, path: &Path, deny_warnings: bool) -> Result<Scene, Failure> {
        let Search { options, passes } = &self.search;
        if !options.0.is_empty() || passes.is_some() || !self.only.is_empty() {
            let message =
                "error: a scene says itself how its kernels are made\n  = help: write the options into it";
            return Err(Failure::Input(message.to_owned()));
        }
        let mut progress: Option<Progress> = None;
        let mut step =
            |name: &str, kernels: usize| progress.get_or_insert_with(|| Progress::new(kernels)).step(name);
        let mut warned = false;
        let mut warn = |warnings: Diagnostics| {
            warned = true;
            complain(&(warnings.render(colour()) + "\n"));
        };
        let scene = scene::compile(path, &mut Listener { step: &mut step, warn: &mut warn });
        let scene = scene.map_err(|wrong| Failure::Input(wrong.render(colour())))?;
        if warned && deny_warnings { Err(Failure::Check) } else { Ok(scene) }
    }
}

/// Prints warnings.
pub(super) fn warn(source: &Source, warnings: &[Diagnostic]) {
    let warnings = Diagnostics::new(source.clone(), warnings.to_vec());
    if !warnings.list.is_empty() {
        complain(&(warnings.render(colour()) + "\n"));
    }
}

/// A selection of force functions.
pub(super) struct Files<'a> {
    /// Force files, or folders to search for force files.
    pub(super) paths: &'a [PathBuf],
    /// Names of functions; empty selects all.
    pub(super) only: &'a [String],
}

impl Files<'_> {
    /// Compiles the selection; calls `warn` for each file that compiles, even if others have errors.
    pub(super) fn compile(&self, request: &Request, warn: &dyn Fn(&Unit)) -> Result<Vec<Unit>, Failure> {
        let found = files::read_all(self.paths);
        let mut errors = found.errors;
        let progress = Progress::new(found.sources.len());
        let wanted = |name: &str| self.only.is_empty() || self.only.iter().any(|only| only == name);
        let (units, wrong) =
            files::compile_all(found.sources, &wanted, request, &mut |name| progress.step(name));
        errors.extend(wrong.iter().map(|diagnostics| diagnostics.render(colour())));
        drop(progress);
        units.iter().for_each(warn);
        if errors.is_empty() {
            errors.extend(files::duplicates(&units));
            errors.extend(self.unknown_names(&units));
            errors.extend(files::unknown(&units, &request.known));
        }
        if errors.is_empty() { Ok(units) } else { Err(Failure::Input(errors.join("\n\n"))) }
    }

    /// An error for each selected name that does not exist.
    fn unknown_names(&self, units: &[Unit]) -> Vec<String> {
        let names: Vec<&str> =
            units.iter().flat_map(|unit| unit.compiled.names.iter().map(String::as_str)).collect();
        let unknown = self.only.iter().filter(|only| !names.contains(&only.as_str()));
        unknown
            .map(|only| {
                let near = suggest::did_you_mean(only, names.iter().copied());
                let help = near.unwrap_or_else(|| "`forcec stats` lists the force functions".to_owned());
                format!("error: no force function `{only}`\n  = help: {help}")
            })
            .collect()
    }
}
