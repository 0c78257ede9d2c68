//! The pipeline, from a source text to kernels.
//!
//! text → AST → checked → vector graph → derivatives → optimised scalars → statements; `emit` prints these.

use crate::derive::derive;
use crate::kernel::{Kernel, Once, Preparation};
use crate::layout::Lanes;
use crate::layout::anchors::anchored;
use crate::lower::MOST_OPERATIONS;
use crate::lower::vocabulary::vocabulary;
use crate::math::exact::Exact;
use crate::math::number::Precision;
use crate::model::bodies::Parameter;
use crate::model::outputs::{Axis, Extra, Part};
use crate::optimize::prepare::{self, Split};
use crate::optimize::{Optimized, optimize};
pub use crate::options::Request;
use crate::options::plan::Mode;
use crate::options::specialize::{Specialization, remarks};
use crate::options::{Choice, suggestion};
use crate::scalar::{PassReport, Program};
use crate::schedule::meanings::Meanings;
use crate::schedule::{Schedule, Style, schedule};
use crate::show::formula::{Dialect, Formulas};
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::Source;
use crate::source::suggest;
use crate::syntax::ast::Function;
use crate::vector::definition::{Definition, Law, Row};
use crate::vector::{FORMULATIONS, Formulation};
use crate::{check, syntax};
use std::time::{Duration, Instant};

impl Stages {
    /// The outputs that the kernel computes, in order.
    pub fn outputs(&self) -> Vec<Part> {
        self.program.arrays.iter().map(|array| array.part).collect()
    }
}

/// A compiled source text.
pub struct Compiled {
    /// The source text.
    pub source: Source,
    /// Lines of its doc comment.
    pub docs: Vec<String>,
    /// Names of all its force functions, compiled or not.
    pub names: Vec<String>,
    /// Wanted force functions, in source order.
    pub functions: Vec<Stages>,
    /// The warnings about the source text.
    pub warnings: Vec<Diagnostic>,
}

/// A compiled force function with all its stages.
pub struct Stages {
    /// The syntax tree in text form.
    pub ast: String,
    /// The definition of the function, simplified.
    pub definition: Definition,
    /// The definition as written: the reference for checks.
    pub source: Definition,
    /// The optimised program of the kernel.
    pub program: Program,
    /// How its derivatives are formulated.
    pub formulation: Formulation,
    /// The state of the kernel after lowering and after each pass.
    pub report: Vec<PassReport>,
    /// Statements in order, ready to be printed.
    pub kernel: Kernel,
    /// The time for compiling, from the checked function to statements.
    pub time: Duration,
}

/// Compiles the wanted force functions of a source text.
pub fn compile(
    source: &Source,
    wanted: &dyn Fn(&str) -> bool,
    request: impl Into<Request>,
) -> Result<Compiled, Diagnostics> {
    compile_file(&syntax::parse(source)?, wanted, request)
}

/// Compiles the wanted force functions of a parsed file; the request and attributes may specialize them.
pub fn compile_file(
    file: &syntax::ast::File,
    wanted: &dyn Fn(&str) -> bool,
    request: impl Into<Request>,
) -> Result<Compiled, Diagnostics> {
    let Elaborated { functions, names, warnings } = elaborated(file, wanted, request)?;
    let functions = compile_all(file, functions)?;
    Ok(Compiled { source: file.source.clone(), docs: file.docs(), names, functions, warnings })
}

/// A checked force function and what is asked of it.
#[derive(Clone)]
pub(crate) struct Asked {
    /// The definition, simplified.
    pub(crate) definition: Definition,
    /// The definition as written.
    pub(crate) source: Definition,
    /// The request, with the options of its attributes.
    pub(crate) request: Request,
}

/// The wanted force functions of a file, checked.
pub(crate) struct Elaborated {
    pub(crate) functions: Vec<Asked>,
    /// Names of all force functions of the file.
    pub(crate) names: Vec<String>,
    pub(crate) warnings: Vec<Diagnostic>,
}

/// Checks a parsed file once, for any number of kernels of each wanted function.
pub(crate) fn elaborated(
    file: &syntax::ast::File,
    wanted: &dyn Fn(&str) -> bool,
    request: impl Into<Request>,
) -> Result<Elaborated, Diagnostics> {
    let request = request.into();
    let known = |own: &Function| match wanted(&own.name.text) {
        true => request.of(own.choices()).known,
        false => Specialization::default(),
    };
    let checked = check::check_knowing(file, &known, wanted, true)?;
    let names = checked.definitions.iter().map(|definition| definition.name.clone()).collect();
    let definitions = checked.definitions.into_iter().filter(|definition| wanted(&definition.name));
    let functions = definitions.zip(checked.sources).map(|(definition, source)| {
        let own = file.function(&definition.name).map(Function::choices);
        Asked { request: request.of(own.into_iter().flatten()), definition, source }
    });
    Ok(Elaborated { functions: functions.collect(), names, warnings: checked.warnings })
}

/// Compiles checked functions, unless the options of one contradict the function.
pub(crate) fn compile_all(
    file: &syntax::ast::File,
    functions: Vec<Asked>,
) -> Result<Vec<Stages>, Diagnostics> {
    let functions = optimize_all(file, functions)?;
    Ok(functions.into_iter().map(|function| function.stages(file)).collect())
}

/// Derives and optimizes checked functions, unless the options of one contradict the function.
pub(crate) fn optimize_all(
    file: &syntax::ast::File,
    mut functions: Vec<Asked>,
) -> Result<Vec<Unscheduled>, Diagnostics> {
    let (mut errors, mut arguments) = (Vec::new(), Vec::new());
    for Asked { definition, request, .. } in &functions {
        errors.extend(misfits(file, definition, request, &functions));
        errors.extend(valueless(definition, request.parts()));
        match extras(file, definition, request) {
            Ok(extras) => arguments.push(extras),
            Err(error) => errors.push(error),
        }
    }
    if !errors.is_empty() {
        return Err(Diagnostics::new(file.source.clone(), errors));
    }
    for (Asked { definition, .. }, extras) in functions.iter_mut().zip(arguments) {
        definition.graph.signature.extras = extras;
    }
    let functions: Result<Vec<Unscheduled>, Diagnostic> =
        functions.into_iter().map(Unscheduled::new).collect();
    functions.map_err(|error| Diagnostics::new(file.source.clone(), vec![error]))
}

/// Errors in the options of a function: bodies and parameters that the function does not have (for a module's
/// options: that no function of the module has), and outputs or lanes that contradict the layout.
fn misfits(
    file: &syntax::ast::File,
    definition: &Definition,
    request: &Request,
    all: &[Asked],
) -> Vec<Diagnostic> {
    let mut errors = Vec::new();
    let Some(function) = file.function(&definition.name) else { return errors };
    for stated in &function.options {
        let names = matches!(stated.choice, Choice::Outputs(_) | Choice::Lanes(_));
        if let Some((message, help)) = request.conflict().filter(|_| names && errors.is_empty()) {
            errors.push(Diagnostic::error(stated.span, message, "stated here").help(help));
        }
        let Choice::Known(known) = &stated.choice else { continue };
        let functions = all.iter().filter(|own| stated.shared || own.definition.name == definition.name);
        let candidates: Vec<(&str, String)> =
            functions.flat_map(|own| nameable(&own.definition, &own.request)).collect();
        for ((what, name), place) in known.names().zip(&stated.places) {
            let own = candidates.iter().filter(|(kind, _)| *kind == what).map(|(_, name)| name.as_str());
            let own: Vec<&str> = own.collect();
            if own.contains(&name.as_str()) {
                continue;
            }
            let whose =
                if stated.shared { "no function here".to_owned() } else { format!("`{}`", definition.name) };
            let message = format!("no {what} `{name}`");
            let label = format!("{whose} has {}such a {what}", if stated.shared { "" } else { "no " });
            errors.push(Diagnostic::error(*place, message, label).help(suggestion(name, &own)));
        }
    }
    errors
}

/// Names that a specialization can use, each with its kind.
fn nameable(definition: &Definition, request: &Request) -> Vec<(&'static str, String)> {
    let signature = &definition.graph.signature;
    let bodies = signature.bodies.iter().map(|body| ("body", body.name.clone()));
    let extras = Part::extras(request.parts()).into_iter().map(|extra| extra.parameter(signature).name);
    let parameters = signature.parameters.iter().map(|parameter| parameter.name.clone()).chain(extras);
    bodies.chain(parameters.map(|name| ("parameter", name))).collect()
}

/// An error for every specialized body or parameter that none of the functions has.
pub(crate) fn unknown<'f>(
    functions: impl Iterator<Item = &'f Stages> + Clone,
    known: &Specialization,
) -> Vec<Diagnostic> {
    let signatures = || functions.clone().map(|function| &function.definition.graph.signature);
    let bodies: Vec<&str> = signatures().flat_map(|s| &s.bodies).map(|body| body.name.as_str()).collect();
    let parameters = signatures().flat_map(|s| s.parameters.iter().chain(&s.extras));
    let parameters: Vec<&str> = parameters.map(|p| p.name.as_str()).collect();
    let known =
        known.names().map(|(what, name)| (what, name, if what == "body" { &bodies } else { &parameters }));
    let unknown = known.filter(|(_, name, names)| !names.contains(&name.as_str()));
    let error = |(what, name, names): (&str, &String, &Vec<&str>)| {
        let error = Diagnostic::file(format!("no force function has a {what} `{name}`"));
        Diagnostic { help: suggest::did_you_mean(name, names.iter().copied()), ..error }
    };
    unknown.map(error).collect()
}

/// An error if outputs need a value but the law is a force, or need rows but it is not a constraint.
pub(crate) fn valueless(definition: &Definition, outputs: &[Part]) -> Option<Diagnostic> {
    let pulls = outputs.iter().find(|part| part.row().of_constraints);
    if let Some(part) = pulls.filter(|_| !definition.law.has_multipliers()) {
        let message = format!("`{}` is not a constraint, and so has no `{}`", definition.name, part.name());
        return Some(
            Diagnostic::error(definition.span, message, "only constraints have")
                .help("name the constraints with `--only`, or leave this output out"),
        );
    }
    let wanted = outputs.iter().find(|part| part.row().rows == Axis::Row);
    wanted.filter(|_| definition.law.rows() == 0).map(|part| {
        let message = format!("the force `{}` has no `{}`", definition.name, part.name());
        Diagnostic::error(definition.span, message, "only constraints and energies have")
            .help("name the other functions with `--only`, or ask for `force`, `dfdx` and `dfdv`")
    })
}

/// The kernel for these precisions, with unrepresentable numbers split up; or an error if that is impossible.
pub(crate) fn fitted(
    definition: &Definition,
    kernel: &Kernel,
    precisions: &[Precision],
) -> Result<Kernel, Diagnostic> {
    let mut kernel = kernel.clone();
    for &precision in precisions {
        let signature = &definition.graph.signature;
        let known = signature.parameters.iter().chain(&signature.extras);
        let known = known.flat_map(|parameter| parameter.value.iter().flatten().map(move |x| (parameter, x)));
        if let Some((parameter, number)) = known.clone().find(|(_, number)| !number.fits(precision)) {
            let message = format!("`{}` is set to a number that does not fit `{precision}`", parameter.name);
            return Err(Diagnostic::error(definition.span, message, misfit(number, precision))
                .help("set a number of a size that fits, in other units"));
        }
        let mut fit = kernel.schedule.fit(precision);
        if let Preparation::Once(once) = &mut kernel.preparation {
            fit = fit.and_then(|()| once.schedule.fit(precision));
        }
        let Err(number) = fit else { continue };
        let (size, inverse) = (number.abs(), number.recip().abs());
        let mut stated = definition.extremes.iter();
        let stated = stated.find(|(own, _)| [&size, &inverse].contains(&&own.abs()));
        let (place, label) = match stated {
            Some((own, place)) if own.abs() == size => (*place, misfit(&size, precision)),
            Some((_, place)) => (*place, format!("its inverse {}", misfit(&size, precision))),
            None => (definition.span, format!("in its kernel {}", misfit(&size, precision))),
        };
        let help = "choose other units, or raise a quotient and not its parts, as in `(x / a).powi(n)`";
        let wider = if precision == Precision::F32 { "; or build for `f64`" } else { "" };
        return Err(Diagnostic::error(place, format!("a number does not fit `{precision}`"), label)
            .help(format!("{help}{wider}")));
    }
    Ok(kernel)
}

/// The part of a message that says what an unrepresentable number becomes.
fn misfit(number: &Exact, precision: Precision) -> String {
    let near = match precision {
        Precision::F64 => number.to_f64(),
        Precision::F32 => f64::from(number.to_f32()),
    };
    let becomes = match near {
        0.0 => "0",
        near if near.is_finite() => "a subnormal of few digits",
        _ => "infinite",
    };
    format!("{} is {becomes} as `{precision}`", number.about())
}

/// The extra arguments of kernels, with known values. If the function has a parameter of the same name, a set
/// value belongs to that parameter.
fn extras(
    file: &syntax::ast::File,
    definition: &Definition,
    request: &Request,
) -> Result<Vec<Parameter>, Diagnostic> {
    let signature = &definition.graph.signature;
    let mut extras = Vec::new();
    for kind in Part::extras(request.parts()) {
        let mut extra = kind.parameter(signature);
        if signature.parameters.iter().all(|parameter| parameter.name != extra.name) {
            let given = request.known.give(&mut extra);
            let positive = extra.value.iter().flatten().all(|h| !h.is_zero() && !h.is_negative());
            let wrong = match given {
                Err(wrong) => Some(wrong),
                Ok(()) if kind == Extra::Multipliers && extra.value.is_some() => Some((
                    "multipliers are not known beforehand".to_owned(),
                    "leave them an argument; where they are zero, call the kernel with zeros".to_owned(),
                )),
                Ok(()) if kind == Extra::Step && !positive => Some((
                    "the step is positive".to_owned(),
                    "write the time a step takes, as in `step=0.01`".to_owned(),
                )),
                Ok(()) => None,
            };
            if let Some((message, help)) = wrong {
                let stated = file.function(&definition.name).and_then(|function| function.sets(&extra.name));
                let label = if stated.is_some() { "set here" } else { "the function it is set for" };
                let place = stated.unwrap_or(definition.span);
                return Err(Diagnostic::error(place, message, label).help(help));
            }
        }
        extras.push(extra);
    }
    Ok(extras)
}

/// An optimized function, from which kernels for any number of instances can be scheduled.
pub(crate) struct Unscheduled {
    pub(crate) definition: Definition,
    source: Definition,
    request: Request,
    optimized: Optimized,
    meanings: Meanings,
    time: Duration,
}

impl Unscheduled {
    /// Derives and optimizes a function; a kernel that is too long is an error.
    fn new(asked: Asked) -> Result<Unscheduled, Diagnostic> {
        let started = Instant::now();
        let Asked { definition, source, request } = asked;
        let derive = |formulation| derive(&definition, request.parts(), formulation);
        let optimized = optimize(derive, request.plan, Some(&source));
        let optimized = optimized.ok_or_else(|| {
            let label = format!("its kernel has more than {MOST_OPERATIONS} operations");
            Diagnostic::error(definition.span, "the function is too large", label)
                .help("shorten the ranges of its loops, or split it into several force functions")
        })?;
        let vocabulary = vocabulary(derive(FORMULATIONS[0]), MOST_OPERATIONS);
        let meanings = Meanings::new(&vocabulary, definition.law.has_multipliers());
        Ok(Unscheduled { definition, source, request, optimized, meanings, time: started.elapsed() })
    }

    /// The kernel for this number of instances.
    pub(crate) fn kernel(&self, lanes: Lanes) -> Kernel {
        let Unscheduled { definition, request, optimized, meanings, .. } = self;
        let style = Style {
            strict: request.plan.mode == Mode::Strict,
            fma: request.plan.fma,
            single: !lanes.is_one(),
            adds: request.layout.row().adds,
        };
        let laid = request.layout.lay(&optimized.program, definition.symmetric());
        let program = laid.as_ref().map_or(&optimized.program, |(program, _)| program);
        let (schedule, preparation) = if request.prepare {
            prepared(program, style, meanings)
        } else {
            (schedule(program, style, meanings), Preparation::Unasked)
        };
        let known = request.known.suffix(&definition.graph.signature);
        Kernel {
            name: format!("{}{known}{}", definition.name, request.layout.suffix(lanes)),
            docs: definition.docs.clone(),
            formulas: formulas(definition),
            schedule,
            layout: request.layout,
            packing: laid.map(|(_, packing)| packing),
            anchored: anchored(&optimized.program),
            lanes,
            preparation,
        }
    }

    /// All stages of the requested kernel.
    fn stages(self, file: &syntax::ast::File) -> Stages {
        let started = Instant::now();
        let kernel = self.kernel(Lanes::of(self.request.lanes));
        let Unscheduled { definition, source, optimized, time, .. } = self;
        let time = time + started.elapsed();
        let Optimized { program, formulation, report } = optimized;
        let ast = file.function(&definition.name).map_or_else(String::new, ToString::to_string);
        Stages { ast, definition, source, program, formulation, report, kernel, time }
    }
}

/// The statements of a program, with values that depend on parameters alone computed once.
fn prepared(program: &Program, style: Style, meanings: &Meanings) -> (Schedule, Preparation) {
    let whole = schedule(program, style, meanings);
    match prepare::split(program, style.strict) {
        None => (whole, Preparation::Nothing),
        Some(Split { once, rest, kept }) => {
            let first = schedule(&once, Style { adds: false, ..style }, meanings);
            let once = Once { schedule: first, kept, whole: whole.operations() };
            (schedule(&rest, style, meanings), Preparation::Once(Box::new(once)))
        }
    }
}

/// Maximum length of a formula in the comment of a kernel.
const LONGEST_FORMULA: usize = 100;

/// Maximum number of formulas in the comment of a kernel.
const MOST_FORMULAS: usize = 8;

/// The formulas in the comment of a kernel.
fn formulas(definition: &Definition) -> Vec<String> {
    let graph = &definition.graph;
    let (name, roots, law) = match &definition.law {
        Law::Constraint { rows, unilateral, .. } => {
            let rows = rows.iter().map(|row| match row {
                Row::Real(x) => x.index() as u32,
                Row::Vector(v) => v.index() as u32,
            });
            let law = if *unilateral {
                "F = −Jᵀ λ, λ = min(stiffness C + damping dC/dt, 0) where C < 0, else 0"
            } else {
                "F = −Jᵀ (stiffness C + damping dC/dt)"
            };
            ("C", rows.collect::<Vec<u32>>(), law)
        }
        Law::Energy(energy) => ("E", vec![energy.index() as u32], "F = −∂E/∂X"),
        Law::Force(forces) => {
            let parts = forces.iter().flat_map(|f| [Some(f.force), f.torque]).flatten();
            ("F", parts.map(|v| v.index() as u32).collect(), "")
        }
    };
    let formulas = Formulas::new(graph, Dialect::Text, &roots);
    let values: Vec<&str> = roots.iter().map(|root| formulas.formula(*root as usize)).collect();
    let fits = |line: &String| line.chars().count() <= LONGEST_FORMULA;
    let mut lines: Vec<String> = formulas.lines().map(|(name, text)| format!("{name} = {text}")).collect();
    let short = lines.iter().all(fits);
    let whole = match values.as_slice() {
        [value] => format!("{name} = {value}"),
        values => format!("{name} = ({})", values.join(", ")),
    };
    if fits(&whole) {
        lines.push(whole);
    } else {
        // One row per line.
        let last = values.len() - 1;
        lines.extend(values.iter().enumerate().map(|(row, value)| {
            let open = if row == 0 { format!("{name} = (") } else { " ".repeat(name.len() + 4) };
            format!("{open}{value}{}", if row == last { ")" } else { "," })
        }));
    }
    if !short || lines.len() > MOST_FORMULAS || !lines.iter().all(fits) {
        lines = vec![format!("{name}: see the source")];
    }
    lines.extend((!law.is_empty()).then(|| law.to_owned()));
    lines.extend(remarks(&graph.signature));
    lines
}
