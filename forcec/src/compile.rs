//! The pipeline on one screen: a source text to kernels.
//!
//! text → AST → checked → vector graph → derivatives → optimised scalars → statements; `targets` turns these into text.

use crate::definition::{Definition, Law, Row};
use crate::derive::derive;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::formula::{Dialect, Formulas};
use crate::kernel::{Kernel, Once, Preparation};
use crate::layouts::Layout;
use crate::optimize::{Optimized, optimize};
use crate::outputs::{Axis, Part};
use crate::plan::{Effort, Mode, Plan};
use crate::prepare::{self, Split};
use crate::scalar::{Program, Step};
use crate::schedule::{Schedule, Style, schedule};
use crate::span::Source;
use crate::specialize::{Specialization, remarks};
use crate::vector::Formulation;
use crate::{check, syntax};
use std::time::{Duration, Instant};

impl Stages {
    /// What the kernel computes, in order.
    pub fn outputs(&self) -> Vec<Part> {
        self.program.arrays.iter().map(|array| array.part).collect()
    }
}

/// What is wanted of force functions.
#[derive(Clone, Debug)]
pub struct Request {
    /// How to optimise.
    pub plan: Plan,
    /// What is known beforehand.
    pub known: Specialization,
    /// What kernels compute, in the order of the table, where the layout leaves that open.
    pub outputs: Vec<Part>,
    /// Where results stand.
    pub layout: Layout,
    /// How many instances a kernel computes at once.
    pub lanes: usize,
    /// Whether what depends on parameters alone is computed once, by a function of its own.
    pub prepare: bool,
}

impl Default for Request {
    fn default() -> Request {
        Request {
            plan: Plan::default(),
            known: Specialization::default(),
            outputs: Part::DEFAULT.to_vec(),
            layout: Layout::Dense,
            lanes: 1,
            prepare: false,
        }
    }
}

impl Request {
    /// What kernels compute, in the order of the table.
    pub fn parts(&self) -> &[Part] {
        self.layout.row().computes.unwrap_or(&self.outputs)
    }
}

impl Request {
    /// Why no kernel can be like that, as a message; none if it can.
    pub fn impossible(&self) -> Option<String> {
        let row = self.layout.row();
        (row.adds && self.lanes > 1).then(|| {
            let blocks = Layout::Blocks.row().name;
            format!(
                "error: the layout `{}` adds to what one instance is given, and {} lanes may share a body\n  = help: leave \
                 `lanes` out, or add what the layout `{blocks}` computes",
                row.name, self.lanes
            )
        })
    }
}

impl From<Plan> for Request {
    fn from(plan: Plan) -> Request {
        Request { plan, ..Request::default() }
    }
}

impl From<Effort> for Request {
    fn from(effort: Effort) -> Request {
        Plan::from(effort).into()
    }
}

/// A compiled source text.
pub struct Compiled {
    /// The text.
    pub source: Source,
    /// Its doc comment, a line each.
    pub docs: Vec<String>,
    /// The names of all its force functions, compiled or not.
    pub names: Vec<String>,
    /// The force functions that were wanted, in source order.
    pub functions: Vec<Stages>,
    /// What deserves a look.
    pub warnings: Vec<Diagnostic>,
}

/// A compiled force function, every stage of it.
pub struct Stages {
    /// The syntax tree in text form.
    pub ast: String,
    /// What the function states, simplified.
    pub definition: Definition,
    /// What it states, as it was written: the reference for checks.
    pub source: Definition,
    /// What the kernel computes.
    pub program: Program,
    /// How its derivatives are written.
    pub formulation: Formulation,
    /// What it was after lowering and after each pass.
    pub report: Vec<Step>,
    /// Statements in order, ready to be printed.
    pub kernel: Kernel,
    /// How long compiling took, from the checked function to statements.
    pub time: Duration,
}

/// Compiles the force functions of a source text whose names are wanted.
pub fn compile(
    source: &Source,
    wanted: &dyn Fn(&str) -> bool,
    request: impl Into<Request>,
) -> Result<Compiled, Diagnostics> {
    compile_file(&syntax::parse(source)?, wanted, request)
}

/// Compiles the force functions of a parsed file whose names are wanted, and of which something may be known.
pub fn compile_file(
    file: &syntax::ast::File,
    wanted: &dyn Fn(&str) -> bool,
    request: impl Into<Request>,
) -> Result<Compiled, Diagnostics> {
    let request = request.into();
    let checked = check::check_knowing(file, &request.known, wanted)?;
    let names = checked.definitions.iter().map(|definition| definition.name.clone()).collect();
    let definitions = checked.definitions.into_iter().filter(|definition| wanted(&definition.name));
    let definitions: Vec<Definition> = definitions.collect();
    let valueless = definitions.iter().filter_map(|definition| valueless(definition, request.parts()));
    let errors: Vec<Diagnostic> = valueless.collect();
    if !errors.is_empty() {
        return Err(Diagnostics::new(file.source.clone(), errors));
    }
    let functions = definitions.into_iter().map(|definition| stages(file, definition, &request)).collect();
    let docs = file.docs();
    Ok(Compiled { source: file.source.clone(), docs, names, functions, warnings: checked.warnings })
}

/// That a force has no value is an error where its value is wanted.
fn valueless(definition: &Definition, outputs: &[Part]) -> Option<Diagnostic> {
    let wanted = outputs.iter().any(|part| part.row().rows == Axis::Row);
    (wanted && definition.law.rows() == 0).then(|| {
        let message = format!("the force `{}` has neither value nor jacobian", definition.name);
        Diagnostic::error(definition.span, message, "only constraints and energies have")
            .help("name the other functions with `--only`, or ask for `force`, `dfdx` and `dfdv`")
    })
}

fn stages(file: &syntax::ast::File, mut definition: Definition, request: &Request) -> Stages {
    let started = Instant::now();
    let signature = &mut definition.graph.signature;
    for extra in Part::extras(request.parts()) {
        let mut extra = extra.parameter(signature);
        // What does not fit is no error: a parameter of that name is meant.
        let _ = request.known.give(&mut extra);
        signature.extras.push(extra);
    }
    let plan = request.plan;
    // What a function states of itself holds whoever compiles it.
    let plan = file.function(&definition.name).map_or(plan, |own| Plan {
        mode: own.mode.unwrap_or(plan.mode),
        fma: plan.fma || own.fma,
        ..plan
    });
    let optimized = optimize(|formulation| derive(&definition, request.parts(), formulation), plan);
    let style = Style {
        strict: plan.mode == Mode::Strict,
        fma: plan.fma,
        single: request.lanes > 1,
        adds: request.layout.row().adds,
    };
    let laid = request.layout.lay(&optimized.program, definition.symmetric());
    let program = laid.as_ref().map_or(&optimized.program, |(program, _)| program);
    let (schedule, preparation) = if request.prepare {
        prepared(program, style)
    } else {
        (schedule(program, style), Preparation::Unasked)
    };
    let time = started.elapsed();
    let kernel = Kernel {
        name: format!(
            "{}{}{}",
            definition.name,
            request.known.suffix(&definition.graph.signature),
            request.layout.suffix(request.lanes)
        ),
        docs: definition.docs.clone(),
        formulas: formulas(&definition),
        schedule,
        layout: request.layout,
        packing: laid.map(|(_, packing)| packing),
        lanes: request.lanes,
        preparation,
    };
    let source = check::elaborate(file, &definition.name, &request.known);
    let ast = file.function(&definition.name).map_or_else(String::new, ToString::to_string);
    let Optimized { program, formulation, report } = optimized;
    Stages { ast, definition, source, program, formulation, report, kernel, time }
}

/// The statements of a program in which what depends on parameters alone is computed once.
fn prepared(program: &Program, style: Style) -> (Schedule, Preparation) {
    let whole = schedule(program, style);
    match prepare::split(program, style.strict) {
        None => (whole, Preparation::Nothing),
        Some(Split { once, rest, kept }) => {
            let first = schedule(&once, Style { adds: false, ..style });
            let once = Once { schedule: first, kept, whole: whole.operations() };
            (schedule(&rest, style), Preparation::Once(Box::new(once)))
        }
    }
}

/// Longer definitions are left to `forcec show`.
const LONGEST_FORMULA: usize = 100;

/// What the kernel computes, in a few lines.
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
    let mut lines: Vec<String> = formulas.lines().map(|(name, text)| format!("{name} = {text}")).collect();
    lines.push(match values.as_slice() {
        [value] => format!("{name} = {value}"),
        values => format!("{name} = ({})", values.join(", ")),
    });
    if lines.len() > 8 || lines.iter().any(|line| line.chars().count() > LONGEST_FORMULA) {
        lines.clear();
    }
    lines.extend((!law.is_empty()).then(|| law.to_owned()));
    lines.extend(remarks(&graph.signature));
    lines
}
