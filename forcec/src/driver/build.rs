//! For build scripts: force files to kernels while cargo builds.
//!
//! In: force files or folders of them. Out: what the command line writes, in `OUT_DIR` or a folder of choice, with lines
//! that tell cargo when to run again; or errors as cargo shows them.

use crate::compile::Request;
pub use crate::driver::files::BuildError;
use crate::driver::files::{self, Unit};
#[cfg(feature = "scenes")]
use crate::driver::scene::{self, Listener};
use crate::kernel::{Precision, Target};
use crate::layout::{LANES, Layout};
use crate::math::exact::Exact;
use crate::model::outputs::Part;
use crate::source::diagnostic::Diagnostics;
use crate::{Effort, Mode};
use std::path::{Path, PathBuf};

/// Compiles force files from a build script.
///
/// In `main` of `build.rs`:
///
/// ```no_run
/// forcec::Build::new().input("forces").run();
/// ```
///
/// Kernels are Rust in double precision unless told otherwise. Beside them stands a `mod.rs` that names them all, so that
/// one line makes them part of the crate:
///
/// ```ignore
/// include!(concat!(env!("OUT_DIR"), "/mod.rs"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Build {
    inputs: Vec<PathBuf>,
    scene: Option<PathBuf>,
    out: Option<PathBuf>,
    request: Request,
}

impl Build {
    /// Nothing to compile yet.
    pub fn new() -> Build {
        Build::default()
    }

    /// A force file, or a folder that is searched for them; relative to the crate. May be repeated.
    pub fn input(mut self, path: impl Into<PathBuf>) -> Build {
        self.inputs.push(path.into());
        self
    }

    /// A scene file, which says itself what is compiled and how: it goes without inputs and options but `target`, `real` and
    /// `out`, and where it writes is said here; relative to the crate. Of several the last counts.
    #[cfg(feature = "scenes")]
    pub fn scene(mut self, path: impl Into<PathBuf>) -> Build {
        self.scene = Some(path.into());
        self
    }

    /// Where to write; `OUT_DIR` unless told otherwise.
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Build {
        self.out = Some(folder.into());
        self
    }

    /// What to write; Rust unless told otherwise. May be repeated.
    pub fn target(mut self, target: Target) -> Build {
        self.request.targets.push(target);
        self
    }

    /// The precision of the kernels; double unless told otherwise. May be repeated.
    pub fn real(mut self, precision: Precision) -> Build {
        self.request.precisions.push(precision);
        self
    }

    /// What kernels compute; F, ∂F/∂X and ∂F/∂V unless told otherwise.
    pub fn outputs(mut self, parts: &[Part]) -> Build {
        self.request.outputs = Part::in_order(parts.to_vec());
        self
    }

    /// Where results stand; `dense` unless told otherwise.
    pub fn layout(mut self, layout: Layout) -> Build {
        self.request.layout = layout;
        self
    }

    /// How many instances a kernel computes at once; one unless told otherwise.
    ///
    /// Panics if that is none of [`LANES`].
    pub fn lanes(mut self, lanes: usize) -> Build {
        assert!(LANES.contains(&lanes), "lanes are {LANES:?}");
        self.request.lanes = lanes;
        self
    }

    /// Whether what depends on parameters alone is computed once, by a function of its own.
    pub fn prepare(mut self, prepare: bool) -> Build {
        self.request.prepare = prepare;
        self
    }

    /// A body that never moves. May be repeated.
    pub fn fixed(mut self, body: impl Into<String>) -> Build {
        self.request.known.fixed.push(body.into());
        self
    }

    /// A parameter whose value is known, entry by entry. May be repeated.
    ///
    /// Panics if a number is not finite.
    pub fn set(mut self, parameter: impl Into<String>, value: &[f64]) -> Build {
        let exact = |x: &f64| Exact::from_f64(*x).expect("a finite number");
        self.request.known.set.push((parameter.into(), value.iter().map(exact).collect()));
        self
    }

    /// How long to look for fewer operations.
    pub fn effort(mut self, effort: Effort) -> Build {
        self.request.plan.effort = effort;
        self
    }

    /// What kernels may do to rounding.
    pub fn mode(mut self, mode: Mode) -> Build {
        self.request.plan.mode = mode;
        self
    }

    /// Whether products that are added are fused multiplications and additions.
    pub fn fma(mut self, fma: bool) -> Build {
        self.request.plan.fma = fma;
        self
    }

    /// Writes the kernels and tells cargo what to watch. On an error cargo is told, and the process ends with 1.
    ///
    /// Returns the files that were written.
    pub fn run(self) -> Vec<PathBuf> {
        let watch = |path: &Path| println!("cargo::rerun-if-changed={}", path.display());
        self.inputs.iter().chain(&self.scene).for_each(|path| watch(path));
        match self.write() {
            Ok((files, warnings, sources)) => {
                sources.iter().for_each(|path| watch(path));
                warnings.iter().flat_map(lines).for_each(|line| println!("cargo::warning={line}"));
                files
            }
            Err(error) => {
                error.diagnostics.iter().flat_map(lines).for_each(|line| println!("cargo::error={line}"));
                for other in &error.others {
                    let line = other.lines().next().unwrap_or_default();
                    println!("cargo::error={}", line.strip_prefix("error: ").unwrap_or(line));
                }
                eprintln!("{error}");
                std::process::exit(1);
            }
        }
    }

    /// Writes the kernels, prints nothing. Returns the files that were written, and warnings.
    pub fn try_run(self) -> Result<(Vec<PathBuf>, Vec<Diagnostics>), BuildError> {
        self.write().map(|(files, warnings, _)| (files, warnings))
    }

    /// The same, with what a scene was made of.
    fn write(self) -> Result<Written, BuildError> {
        let out = match &self.out {
            Some(folder) => folder.clone(),
            None => match std::env::var_os("OUT_DIR") {
                Some(folder) => PathBuf::from(folder),
                None => {
                    return Err(vec!["error: `OUT_DIR` is not set\n  = help: call `out`".to_owned()].into());
                }
            },
        };
        let Kernels { units, warnings, request, sources } = match &self.scene {
            Some(path) => self.compile_scene(path)?,
            None => self.compile()?,
        };
        let (mut targets, mut precisions) =
            (request.targets_or(Target::Rust), request.precisions_or_double());
        targets.dedup();
        precisions.sort();
        precisions.dedup();
        let failed = |error| BuildError::from(vec![error]);
        let scene = self.scene.as_deref();
        let mut outputs = files::outputs(&units, &out, &targets, &precisions, scene).map_err(failed)?;
        if targets.contains(&Target::Rust) {
            let list = [files::modules(&out, &outputs)?];
            let inputs = units.iter().map(|unit| unit.path.as_path()).chain(scene);
            files::spare_inputs(inputs, &list).map_err(failed)?;
            outputs.extend(list);
        }
        files::write(&out, &outputs).map_err(failed)?;
        Ok((outputs.into_iter().map(|output| output.path).collect(), warnings, sources))
    }

    fn compile(&self) -> Result<Kernels, BuildError> {
        if let Some((message, help)) = self.request.conflict() {
            return Err(vec![format!("error: {message}\n  = help: {help}")].into());
        }
        let found = files::read_all(&self.inputs);
        let (units, diagnostics) = files::compile_all(found.sources, &|_| true, &self.request, &mut |_| {});
        let mut others = found.errors;
        if diagnostics.is_empty() && others.is_empty() {
            others.extend(files::duplicates(&units));
            others.extend(files::unknown(&units, &self.request.known));
        }
        let wrong = BuildError { diagnostics, others };
        if !wrong.is_empty() {
            return Err(wrong);
        }
        let warnings = units.iter().filter(|unit| !unit.compiled.warnings.is_empty());
        let warnings = warnings
            .map(|unit| Diagnostics::new(unit.compiled.source.clone(), unit.compiled.warnings.clone()));
        let warnings = warnings.collect();
        Ok(Kernels { units, warnings, request: self.request.clone(), sources: Vec::new() })
    }

    /// The kernels of a scene, and what of it is printed; what was said here goes before what the scene says.
    #[cfg(feature = "scenes")]
    fn compile_scene(&self, path: &Path) -> Result<Kernels, BuildError> {
        let Request { targets, precisions, .. } = &self.request;
        let printed =
            Request { targets: targets.clone(), precisions: precisions.clone(), ..Request::default() };
        if !self.inputs.is_empty() || printed != self.request {
            let message =
                "error: a scene says itself what is compiled and how\n  = help: write it into the scene";
            return Err(vec![message.to_owned()].into());
        }
        let mut warnings = Vec::new();
        let (step, warn) = (&mut |_: &str, _: usize| (), &mut |found: Diagnostics| warnings.push(found));
        let scene = scene::compile(path, &mut Listener { step, warn })?;
        let mut request = scene.request;
        if !targets.is_empty() {
            request.targets.clone_from(targets);
        }
        if !precisions.is_empty() {
            request.precisions.clone_from(precisions);
        }
        Ok(Kernels { units: scene.units, warnings, request, sources: scene.sources })
    }

    /// Without the feature there is no way to name a scene.
    #[cfg(not(feature = "scenes"))]
    fn compile_scene(&self, _: &Path) -> Result<Kernels, BuildError> {
        self.compile()
    }
}

/// The files that were written, warnings, and the force files and folders of a scene.
type Written = (Vec<PathBuf>, Vec<Diagnostics>, Vec<PathBuf>);

/// Compiled force files.
struct Kernels {
    units: Vec<Unit>,
    warnings: Vec<Diagnostics>,
    /// What is printed of them.
    request: Request,
    /// The force files and folders that a scene names.
    sources: Vec<PathBuf>,
}

/// Each message on a line, as cargo wants it.
fn lines(diagnostics: &Diagnostics) -> Vec<String> {
    let source = &diagnostics.source;
    let line = |diagnostic: &crate::source::diagnostic::Diagnostic| {
        let place = diagnostic.span.map_or_else(String::new, |span| {
            let (line, column) = source.line_column(span.start);
            format!(":{line}:{column}")
        });
        let help = diagnostic.help.as_ref().map_or_else(String::new, |help| format!(" (help: {help})"));
        let lint = diagnostic.lint.map_or_else(String::new, |lint| format!(" [{}]", lint.name()));
        format!("{}{place}: {}{lint}: {}{help}", source.name, diagnostic.message, diagnostic.label)
    };
    diagnostics.list.iter().map(line).collect()
}
