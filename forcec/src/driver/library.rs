//! The compiler as a function from source text to kernel text.
//!
//! In: the text of a force file, and options. Out: one text per kernel, suitable for snapshots, or all
//! errors. A small change of the source causes a small change of the text.

use crate::kernel::{Precision, Target};
use crate::math::exact::Exact;
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::Source;
use crate::{Effort, Layout, Mode, Part, Plan, Request, Specialization};
use std::fmt;

/// The options of [`compile`].
#[derive(Clone, Debug)]
pub struct Options {
    /// The file name in messages.
    pub name: String,
    /// The target language.
    pub target: Target,
    /// The precision.
    pub real: Precision,
    /// The optimization effort.
    pub effort: Effort,
    /// The floating-point mode.
    pub mode: Mode,
    /// Whether kernels use fused multiply-add.
    pub fma: bool,
    /// The outputs of the kernels.
    pub outputs: Vec<Part>,
    /// The output layout.
    pub layout: Layout,
    /// The number of instances that a kernel computes at once: 1, 4 or 8.
    pub lanes: usize,
    /// Whether a separate function computes values of the parameters alone once.
    pub prepare: bool,
    /// Bodies that never move.
    pub fixed: Vec<String>,
    /// Values of parameters at compile time, entry by entry; a single number applies to all entries.
    pub set: Vec<(String, Vec<f64>)>,
}

impl Options {
    /// Converts to a request; fails for values that are not finite.
    fn request(&self) -> Result<Request, Diagnostic> {
        let mut known = Specialization { fixed: self.fixed.clone(), set: Vec::new() };
        for (name, value) in &self.set {
            let exact: Option<Vec<Exact>> = value.iter().map(|x| Exact::from_f64(*x)).collect();
            let exact = exact.filter(|value| !value.is_empty());
            let wrong = || Diagnostic::file(format!("the value of `{name}` is set to no finite numbers"));
            known.set.push((name.clone(), exact.ok_or_else(wrong)?));
        }
        let request = Request {
            plan: Plan { effort: self.effort, mode: self.mode, fma: self.fma, ..Plan::default() },
            known,
            outputs: Part::in_order(self.outputs.clone()),
            layout: self.layout,
            lanes: self.lanes,
            prepare: self.prepare,
            ..Request::default()
        };
        match request.conflict() {
            Some((message, help)) => Err(Diagnostic::file(message).help(help)),
            None => Ok(request),
        }
    }
}

/// C in double precision, from a file called `forces.rs`.
impl Default for Options {
    fn default() -> Options {
        Options {
            name: "forces.rs".to_owned(),
            target: Target::C,
            real: Precision::F64,
            effort: Effort::Default,
            mode: Mode::Balanced,
            fma: false,
            outputs: Part::DEFAULT.to_vec(),
            layout: Layout::Dense,
            lanes: 1,
            prepare: false,
            fixed: Vec::new(),
            set: Vec::new(),
        }
    }
}

/// The kernels of a force file as text, and the warnings.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Name and text of each kernel, in source order.
    pub kernels: Vec<(String, String)>,
    /// Warnings.
    pub warnings: Diagnostics,
}

impl Compiled {
    /// The text of the kernel with this name: in C the function with its comment, in Rust the module.
    ///
    /// Panics if no force function has the name.
    pub fn kernel(&self, name: &str) -> &str {
        match self.kernels.iter().find(|(own, _)| own == name) {
            Some((_, text)) => text,
            None => {
                let names: Vec<&str> = self.kernels.iter().map(|(own, _)| own.as_str()).collect();
                panic!("no force function `{name}`; there are: {}", names.join(", "))
            }
        }
    }
}

/// All kernels, one after another.
impl fmt::Display for Compiled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (_, text)) in self.kernels.iter().enumerate() {
            write!(f, "{}{text}", if index > 0 { "\n" } else { "" })?;
        }
        Ok(())
    }
}

/// Compiles the text of a force file; returns the text of each kernel, or all errors.
///
/// ```
/// let text = "#[energy] fn lift(p: Particle, weight: Real) -> Real { weight * p.position.z }";
/// let compiled = forcec::compile(text, &forcec::Options::default()).unwrap();
/// assert!(compiled.kernel("lift").contains("out->force[2] = -params->weight;"));
///
/// let wrong = forcec::compile("#[energy] fn lift(p: Particle) -> Real { p.hight }", &forcec::Options::default());
/// assert!(wrong.unwrap_err().to_string().contains("hight"));
/// ```
pub fn compile(source: &str, options: &Options) -> Result<Compiled, Diagnostics> {
    let source = Source::new(options.name.as_str(), source);
    let failed = |error: Diagnostic| Diagnostics::new(source.clone(), vec![error]);
    let request = options.request().map_err(failed)?;
    let compiled = crate::compile::compile(&source, &|_| true, request.clone())?;
    let unknown = crate::compile::unknown(compiled.functions.iter(), &request.known);
    if !unknown.is_empty() {
        return Err(Diagnostics::new(source, unknown));
    }
    let kernels = compiled.functions.iter().map(|function| {
        let kernel = crate::compile::fitted(&function.definition, &function.kernel, &[options.real])?;
        let text = crate::emit::kernel(&kernel, options.target, options.real);
        Ok((kernel.name, text))
    });
    Ok(Compiled {
        kernels: kernels.collect::<Result<_, Diagnostic>>().map_err(failed)?,
        warnings: Diagnostics::new(source, compiled.warnings),
    })
}
