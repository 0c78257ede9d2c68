//! Stage 2, syntax tree → typed vector graph.
//!
//! In: a parsed file. Out: one [`Definition`] per force function, and warnings; or all errors about names,
//! types, shapes and ranges. Promise: later stages do not fail on a definition, and need no further checks.

mod assignments;
mod builtins;
mod calls;
mod elaborator;
mod expressions;
mod forces;
mod inline;
mod names;
mod operators;
mod parts;
mod program;
mod resolve;
mod scales;
mod scope;
mod singular;
mod statements;
mod types;
mod values;

#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use builtins::reference;

use crate::options::specialize::Specialization;
use crate::source::diagnostic::{Diagnostic, Diagnostics, Lint, Severity};
use crate::syntax::ast::{Expressions, File, Function, FunctionKind};
use crate::syntax::{report, with_deep_stack};
use crate::vector::Graph;
use crate::vector::definition::Definition;
use elaborator::{Elaborator, Frame};
use program::{FunctionType, Program};
use std::collections::BTreeSet;

/// The checked force functions of a file, with warnings.
#[derive(Clone)]
pub struct Checked {
    /// The force functions, in source order.
    pub definitions: Vec<Definition>,
    /// The wanted force functions without simplification: the reference for all derived results. Empty unless
    /// asked for.
    pub(crate) sources: Vec<Definition>,
    /// Warnings, in source order.
    pub warnings: Vec<Diagnostic>,
}

/// Checks a file; returns all errors if there are any.
#[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
pub fn check(file: &File) -> Result<Checked, Diagnostics> {
    check_knowing(file, &|_| Specialization::default(), &|_| true, false)
}

/// Checks a file whose functions may be specialized. Warnings are limited to the wanted force functions and
/// the helpers that they call; `sources` asks for the wanted functions without simplification as well.
pub fn check_knowing(
    file: &File,
    known: &dyn Fn(&Function) -> Specialization,
    wanted: &dyn Fn(&str) -> bool,
    sources: bool,
) -> Result<Checked, Diagnostics> {
    let known: Vec<Specialization> = file.functions.iter().map(known).collect();
    let all = file.functions.iter().all(|own| own.kind == FunctionKind::Helper || wanted(&own.name.text));
    let wanted = file
        .functions
        .iter()
        .map(|own| if own.kind == FunctionKind::Helper { all } else { wanted(&own.name.text) });
    let wanted = wanted.collect();
    with_deep_stack(|| check_here(file, &known, wanted, sources))
}

/// Marks what the marked functions call, directly or not.
fn reach(wanted: &mut [bool], calls: &[Vec<usize>]) {
    let mut pending: Vec<usize> = (0..wanted.len()).filter(|index| wanted[*index]).collect();
    while let Some(index) = pending.pop() {
        for callee in &calls[index] {
            if !std::mem::replace(&mut wanted[*callee], true) {
                pending.push(*callee);
            }
        }
    }
}

/// Whether a warning is dropped: its function is not wanted, or an attribute of its function allows it.
fn is_answered(warning: &Diagnostic, file: &File, wanted: &[bool]) -> bool {
    let Some(span) = warning.span else { return false };
    // Functions are sorted by position and do not overlap.
    let index = file.functions.partition_point(|function| function.span.end < span.end);
    let around = file.functions.get(index).filter(|function| function.span.start <= span.start);
    around.is_some_and(|function| {
        !wanted[index] || warning.lint.is_some_and(|lint| function.allowed.contains(&lint))
    })
}

fn check_here(
    file: &File,
    known: &[Specialization],
    mut wanted: Vec<bool>,
    sources: bool,
) -> Result<Checked, Diagnostics> {
    let mut diagnostics = Vec::new();
    let program = Program::new(file, &mut diagnostics);
    let names = names::resolve(&program);
    diagnostics.extend(names.diagnostics);
    reach(&mut wanted, &names.calls);
    let program = typed(program, &mut diagnostics);
    check_helpers(&program, &names.recursive, &mut diagnostics);
    let mut definitions: Vec<Definition> = Vec::new();
    let mut in_vain = 0;
    for (index, function) in file.functions.iter().enumerate() {
        // Once faulty functions have used a quarter of the step budget, their errors are enough.
        if function.kind == FunctionKind::Helper || in_vain > elaborator::MOST_STEPS / 4 {
            continue;
        }
        let outcome = forces::define(&program, &names.recursive, index, Graph::new, &known[index]);
        in_vain += if outcome.definition.is_none() { outcome.steps } else { 0 };
        let shown = |diagnostic: &Diagnostic| {
            let allowed = diagnostic.lint.is_some_and(|lint| function.allowed.contains(&lint));
            diagnostic.severity == Severity::Error || wanted[index] && !allowed
        };
        diagnostics.extend(outcome.diagnostics.into_iter().filter(shown));
        definitions.extend(outcome.definition);
    }
    for definition in &mut definitions {
        let allowed = definition.allowed.contains(&Lint::Singular);
        for place in &mut definition.singular {
            place.allowed = allowed || is_answered(&place.warning, file, &wanted);
        }
    }
    let (errors, warnings): (Vec<Diagnostic>, Vec<Diagnostic>) =
        diagnostics.into_iter().partition(|diagnostic| diagnostic.severity == Severity::Error);
    if errors.is_empty() {
        let mut warnings = warnings;
        warnings.retain(|warning| !is_answered(warning, file, &wanted));
        warnings.extend(file.unexplained());
        let warnings = Diagnostics::new(file.source.clone(), warnings).list;
        let force = |index: &usize| file.functions[*index].kind != FunctionKind::Helper && wanted[*index];
        let source = |index| {
            forces::define(&program, &names.recursive, index, Graph::verbatim, &known[index]).definition
        };
        let indices = (0..file.functions.len()).filter(|index| sources && force(index));
        let sources = indices.filter_map(source).collect();
        return Ok(Checked { definitions, sources, warnings });
    }
    // An error in a loop or in a helper occurs many times; the first error at each position is enough.
    let mut places = BTreeSet::new();
    let errors = errors.into_iter().filter(|error| error.span.is_none_or(|span| places.insert(span)));
    Err(report(file.source.clone(), errors.collect()))
}

/// Elaborates a function of a checked file without simplification: the reference for all derived results.
///
/// Panics if the file does not pass [`check`], or has no force function of that name.
#[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
pub fn elaborate(file: &File, name: &str, known: &Specialization) -> Definition {
    let of = |own: &Function| if own.name.text == name { known.clone() } else { Specialization::default() };
    let checked = check_knowing(file, &of, &|own| own == name, true);
    let mut sources = checked.expect("a file that passed the check").sources;
    sources.pop().expect("a force function of this name")
}

/// Resolves the types of all functions and evaluates all constants.
fn typed<'a>(mut program: Program<'a>, diagnostics: &mut Vec<Diagnostic>) -> Program<'a> {
    let signatures = {
        let mut elaborator = Elaborator::new(&program, &[], Graph::new(Default::default()));
        for index in 0..program.constants.len() {
            elaborator.constant(index);
        }
        let mut signatures = Vec::new();
        for function in program.functions {
            let expressions: &Expressions = &function.expressions;
            elaborator.frame = Frame::new(expressions, 0);
            let arguments =
                function.arguments.iter().map(|argument| elaborator.resolve(&argument.ty)).collect();
            let output = elaborator.resolve(&function.output);
            signatures.push(FunctionType { arguments, output });
        }
        diagnostics.append(&mut elaborator.diagnostics);
        signatures
    };
    program.signatures = signatures;
    program
}

/// Step budget for checking helpers on their own.
const QUICK: u64 = 500_000;

/// Checks every helper once on symbolic arguments, called or not, within the budget; called helpers are
/// elaborated again.
fn check_helpers(program: &Program<'_>, recursive: &[bool], diagnostics: &mut Vec<Diagnostic>) {
    let mut spent = 0;
    for (index, function) in program.functions.iter().enumerate() {
        if function.kind != FunctionKind::Helper || spent > QUICK {
            continue;
        }
        let mut elaborator = Elaborator::new(program, recursive, Graph::new(Default::default()));
        let arguments = forces::symbolic(&mut elaborator, &program.signatures[index].arguments);
        elaborator.body(index, arguments);
        spent += elaborator.steps();
        diagnostics.append(&mut elaborator.diagnostics);
        if elaborator.exhausted {
            break;
        }
    }
}
