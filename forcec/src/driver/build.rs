//! Compiles force files from build scripts.
//!
//! In: force files or folders. Out: the files that the command line writes, in `OUT_DIR` or another folder,
//! and the lines that make cargo watch the inputs; or errors in cargo's format.

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
/// By default, kernels are Rust in double precision. A `mod.rs` next to the kernels declares their modules,
/// so one line adds all kernels to the crate:
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
    /// A build without inputs.
    pub fn new() -> Build {
        Build::default()
    }

    /// Adds a force file, or a folder to search for force files; relative to the crate.
    pub fn input(mut self, path: impl Into<PathBuf>) -> Build {
        self.inputs.push(path.into());
        self
    }

    /// A scene file, which lists the kernels and their options; relative to the crate. A scene excludes
    /// `input` and all options except `target`, `real` and `out`. The last call counts.
    #[cfg(feature = "scenes")]
    pub fn scene(mut self, path: impl Into<PathBuf>) -> Build {
        self.scene = Some(path.into());
        self
    }

    /// The output folder; by default `OUT_DIR`.
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Build {
        self.out = Some(folder.into());
        self
    }

    /// Adds a target; by default Rust.
    pub fn target(mut self, target: Target) -> Build {
        self.request.targets.push(target);
        self
    }

    /// Adds a precision; by default double.
    pub fn real(mut self, precision: Precision) -> Build {
        self.request.precisions.push(precision);
        self
    }

    /// The outputs of the kernels; by default F, ∂F/∂X and ∂F/∂V.
    pub fn outputs(mut self, parts: &[Part]) -> Build {
        self.request.outputs = Part::in_order(parts.to_vec());
        self
    }

    /// The output layout; by default `dense`.
    pub fn layout(mut self, layout: Layout) -> Build {
        self.request.layout = layout;
        self
    }

    /// The number of instances that a kernel computes at once; by default one.
    ///
    /// Panics unless the number is 1, 4 or 8.
    pub fn lanes(mut self, lanes: usize) -> Build {
        assert!(LANES.contains(&lanes), "lanes are {LANES:?}");
        self.request.lanes = lanes;
        self
    }

    /// Whether a separate function computes values of the parameters alone once.
    pub fn prepare(mut self, prepare: bool) -> Build {
        self.request.prepare = prepare;
        self
    }

    /// Marks a body as fixed: it never moves. May be called several times.
    pub fn fixed(mut self, body: impl Into<String>) -> Build {
        self.request.known.fixed.push(body.into());
        self
    }

    /// Sets the value of a parameter, entry by entry, at compile time. May be called several times.
    ///
    /// Panics if a number is not finite.
    pub fn set(mut self, parameter: impl Into<String>, value: &[f64]) -> Build {
        let exact = |x: &f64| Exact::from_f64(*x).expect("a finite number");
        self.request.known.set.push((parameter.into(), value.iter().map(exact).collect()));
        self
    }

    /// The optimization effort.
    pub fn effort(mut self, effort: Effort) -> Build {
        self.request.plan.effort = effort;
        self
    }

    /// The floating-point mode.
    pub fn mode(mut self, mode: Mode) -> Build {
        self.request.plan.mode = mode;
        self
    }

    /// Whether kernels use fused multiply-add.
    pub fn fma(mut self, fma: bool) -> Build {
        self.request.plan.fma = fma;
        self
    }

    /// Writes the kernels and prints the lines that make cargo watch the inputs. After an error, prints cargo
    /// messages and exits with code 1.
    ///
    /// Returns the written files.
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

    /// Writes the kernels without printing. Returns the written files and the warnings.
    pub fn try_run(self) -> Result<(Vec<PathBuf>, Vec<Diagnostics>), BuildError> {
        self.write().map(|(files, warnings, _)| (files, warnings))
    }

    /// Writes the kernels; also returns the force files and folders of a scene.
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

    /// Compiles a scene; `target` and `real` of this build override those of the scene.
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

    /// Unreachable: without the feature `scenes`, no method sets a scene.
    #[cfg(not(feature = "scenes"))]
    fn compile_scene(&self, _: &Path) -> Result<Kernels, BuildError> {
        self.compile()
    }
}

/// The written files, the warnings, and the force files and folders of a scene.
type Written = (Vec<PathBuf>, Vec<Diagnostics>, Vec<PathBuf>);

/// Compiled force files.
struct Kernels {
    units: Vec<Unit>,
    warnings: Vec<Diagnostics>,
    /// The request that determines the printed files.
    request: Request,
    /// The force files and folders of a scene.
    sources: Vec<PathBuf>,
}

/// Each message on one line, as cargo requires.
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
