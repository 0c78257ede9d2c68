//! The pipeline on one screen: a source text to kernels.
//!
//! text → AST → checked → vector graph → derivatives → optimised scalars → statements; `targets` turns these into text.

use crate::definition::{Definition, Law, Row};
use crate::derive::derive;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::formula::{Dialect, Formulas};
use crate::kernel::Kernel;
use crate::optimize::{Optimized, Plan, optimize};
use crate::scalar::{Program, Step};
use crate::schedule::schedule;
use crate::span::Source;
use crate::vector::Formulation;
use crate::{check, syntax};
use std::time::{Duration, Instant};

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
    plan: impl Into<Plan>,
) -> Result<Compiled, Diagnostics> {
    compile_file(&syntax::parse(source)?, wanted, plan)
}

/// Compiles the force functions of a parsed file whose names are wanted.
pub fn compile_file(
    file: &syntax::ast::File,
    wanted: &dyn Fn(&str) -> bool,
    plan: impl Into<Plan>,
) -> Result<Compiled, Diagnostics> {
    let plan = plan.into();
    let checked = check::check(file)?;
    let names = checked.definitions.iter().map(|definition| definition.name.clone()).collect();
    let definitions = checked.definitions.into_iter().filter(|definition| wanted(&definition.name));
    let functions = definitions.map(|definition| stages(file, definition, plan)).collect();
    let docs = file.docs();
    Ok(Compiled { source: file.source.clone(), docs, names, functions, warnings: checked.warnings })
}

fn stages(file: &syntax::ast::File, definition: Definition, plan: Plan) -> Stages {
    let started = Instant::now();
    let optimized = optimize(|formulation| derive(&definition, formulation), plan);
    let schedule = schedule(&optimized.program);
    let time = started.elapsed();
    let kernel = Kernel {
        name: definition.name.clone(),
        docs: definition.docs.clone(),
        formulas: formulas(&definition),
        schedule,
    };
    let source = check::elaborate(file, &definition.name);
    let ast = file.function(&definition.name).map_or_else(String::new, ToString::to_string);
    let Optimized { program, formulation, report } = optimized;
    Stages { ast, definition, source, program, formulation, report, kernel, time }
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
    lines
}
