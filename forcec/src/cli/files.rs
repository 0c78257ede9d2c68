//! Files in and out: finding force files, compiling them together, writing results whole or not at all.

use super::{Failure, Input, Progress, colour, complain};
use crate::compile::{Compiled, compile};
use crate::diagnostic::Diagnostics;
use crate::identifiers::{Target, defined_for};
use crate::kernel::{File, Precision};
use crate::span::Source;
use crate::syntax;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// One compiled force file.
pub(super) struct Unit {
    /// Where it was read.
    pub(super) path: PathBuf,
    /// Its kernels.
    pub(super) compiled: Compiled,
}

impl Unit {
    /// The file as a target prints it, under its name without folder and ending.
    pub(super) fn file(&self, precisions: &[Precision]) -> File {
        File {
            stem: self.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
            docs: self.compiled.docs.clone(),
            kernels: self.compiled.functions.iter().map(|function| function.kernel.clone()).collect(),
            precisions: precisions.to_vec(),
        }
    }
}

impl Input {
    /// Reads, checks and compiles everything asked for. Warnings are printed, errors of all files collected.
    pub(super) fn compile(&self) -> Result<Vec<Unit>, Failure> {
        let mut paths = Vec::new();
        let mut errors: Vec<String> = Vec::new();
        for path in &self.paths {
            find(path, true, &mut paths, &mut errors);
        }
        let mut seen = std::collections::BTreeSet::new();
        paths.retain(|path| seen.insert(fs::canonicalize(path).unwrap_or_else(|_| path.clone())));
        let mut sources = Vec::new();
        for path in paths {
            match read(&path) {
                Ok(text) if syntax::mentions_forces(&text) => {
                    let name = path.to_string_lossy().replace('\\', "/");
                    sources.push((path, Source::new(name, text)));
                }
                Ok(_) => {}
                Err(error) => errors.push(error),
            }
        }
        if sources.is_empty() && errors.is_empty() {
            let paths: Vec<String> = self.paths.iter().map(|p| format!("`{}`", p.display())).collect();
            return Err(Failure::Input(format!(
                "error: no force function in {}\n  = help: mark one with `#[constraint]`, `#[energy]` or `#[force]`",
                paths.join(", ")
            )));
        }
        let progress = Progress::new(sources.len());
        let mut units: Vec<Unit> = Vec::new();
        for (path, source) in sources {
            progress.step(&source.name);
            match compile(&source, &|name| self.only.is_empty() || self.only.iter().any(|only| only == name))
            {
                Ok(compiled) => units.push(Unit { path, compiled }),
                Err(diagnostics) => errors.push(diagnostics.render(colour())),
            }
        }
        drop(progress);
        for unit in &units {
            let warnings = Diagnostics::new(unit.compiled.source.clone(), unit.compiled.warnings.clone());
            if !warnings.list.is_empty() {
                complain(&(warnings.render(colour()) + "\n"));
            }
        }
        if errors.is_empty() {
            errors.extend(duplicates(&units));
            errors.extend(self.unknown_names(&units));
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

/// A file as it was named; a folder's Rust files, recursively, in sorted order.
fn find(path: &Path, named: bool, found: &mut Vec<PathBuf>, errors: &mut Vec<String>) {
    let metadata = match fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) => return errors.push(unreadable(path, &error)),
    };
    if !metadata.is_dir() {
        if named || path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path.to_owned());
        }
        return;
    }
    let mut entries = match fs::read_dir(path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>) {
        Ok(entries) => entries,
        Err(error) => return errors.push(unreadable(path, &error)),
    };
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let hidden = entry.file_name().to_string_lossy().starts_with('.') && path.is_dir();
        // A link is not followed into a folder, so that a loop of links ends.
        let folder_link = path.is_symlink() && path.is_dir();
        if !hidden && !folder_link && path.exists() {
            find(&path, false, found, errors);
        }
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> String {
    format!("error: cannot read `{}`: {error}", path.display())
}

fn read(path: &Path) -> Result<String, String> {
    let bytes = fs::read(path).map_err(|error| unreadable(path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..offset].iter().filter(|b| **b == b'\n').count() + 1;
        format!(
            "error: `{}` is not UTF-8\n --> {}:{line}\n  = help: save the file as UTF-8",
            path.display(),
            path.display()
        )
    })
}

/// Kernels of different files that define the same names.
fn duplicates(units: &[Unit]) -> Vec<String> {
    let mut errors = Vec::new();
    let mut defined: BTreeMap<(Target, String), (usize, &str)> = BTreeMap::new();
    for (index, unit) in units.iter().enumerate() {
        for function in &unit.compiled.functions {
            let name = function.definition.name.as_str();
            let mut meets = None;
            for item in defined_for(name).into_iter().filter(|(target, _)| *target == Target::C) {
                let first = *defined.entry(item).or_insert((index, name));
                meets = meets.or((first != (index, name)).then_some(first));
            }
            let Some((first, other)) = meets else { continue };
            let place = |unit: &Unit, name: &str| {
                let kernel = unit.compiled.functions.iter().find(|k| k.definition.name == name);
                let offset = kernel.map_or(0, |k| k.definition.span.start);
                let (line, column) = unit.compiled.source.line_column(offset);
                format!(" --> {}:{line}:{column}", unit.compiled.source.name)
            };
            let what = if name == other {
                format!("two kernels are named `{name}`")
            } else {
                format!("the kernels of `{name}` and `{other}` meet")
            };
            errors.push(format!(
                "error: {what}\n{}\n{}\n  = help: rename one of the functions",
                place(&units[first], other),
                place(unit, name)
            ));
        }
    }
    errors
}

/// A file to be written.
pub(super) struct Output {
    /// Where.
    pub(super) path: PathBuf,
    /// What.
    pub(super) text: String,
}

/// Writes files so that each is there whole or as it was: first all of them beside their places, then renamed.
pub(super) fn write(folder: &Path, outputs: &[Output]) -> Result<(), Failure> {
    let failed = |path: &Path, error: std::io::Error| {
        Failure::Input(format!("error: cannot write `{}`: {error}", path.display()))
    };
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    let mut waiting: Vec<(PathBuf, &Path)> = Vec::new();
    let written = (|| {
        for output in outputs {
            if fs::read(&output.path).is_ok_and(|old| old == output.text.as_bytes()) {
                continue;
            }
            if output.path.is_dir() {
                return Err(failed(&output.path, std::io::ErrorKind::IsADirectory.into()));
            }
            let name = output.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            let temporary = folder.join(format!(".{name}.{}", std::process::id()));
            waiting.push((temporary.clone(), &output.path));
            fs::write(&temporary, &output.text).map_err(|error| failed(&output.path, error))?;
        }
        for (temporary, path) in &waiting {
            fs::rename(temporary, path).map_err(|error| failed(path, error))?;
        }
        Ok(())
    })();
    if written.is_err() {
        for (temporary, _) in &waiting {
            // What was not renamed is removed as far as possible; the error that is reported is the first one.
            let _ = fs::remove_file(temporary);
        }
    }
    written
}
