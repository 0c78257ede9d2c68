//! The elaborator: an interpreter of the source whose values are nodes of a graph.
//!
//! In: expressions of a program. Out: values, errors, and expressions that can be singular. Promise:
//! elaboration ends within its budget for every program; a mistake gives one error and the value `Poison`,
//! and `Poison` gives no further errors.

use crate::check::program::Program;
use crate::check::scope::Scope;
use crate::check::singular::risks::Risk;
use crate::check::types::Type;
use crate::check::values::Value;
use crate::math::exact::Exact;
use crate::math::number::Precision;
use crate::source::diagnostic::Diagnostic;
use crate::source::span::Span;
use crate::syntax::ast::{ExprId, Expressions, FunctionKind};
use crate::vector::{Graph, Real, Truth};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// Maximum number of nodes of a vector graph. A kernel has about ten times as many.
pub(crate) const MOST_NODES: usize = 250_000;
/// Maximum number of steps: evaluated expressions and copied leaves. About a second.
pub(crate) const MOST_STEPS: u64 = 10_000_000;
/// Maximum number of iterations of nested loops.
pub(crate) const MOST_ITERATIONS: u64 = 1_000_000;
/// Maximum depth of nested expressions, through calls.
const DEEPEST: usize = 60_000;
/// Maximum number of extreme numbers with recorded positions.
const MOST_EXTREMES: usize = 100;
/// Maximum number of leaves of one value.
pub(crate) const LARGEST_VALUE: u64 = 1_000_000;

pub(crate) struct Variable {
    pub(crate) value: Value,
}

/// The state of the evaluated function.
pub(crate) struct Frame<'a> {
    pub(crate) expressions: &'a Expressions,
    pub(crate) variables: Scope<'a, Variable>,
    /// One journal per open branch, innermost last: the number of variables declared before the branch, and
    /// the overwritten values of these variables.
    pub(crate) journals: Vec<(usize, Vec<(usize, Value)>)>,
    /// Index of the first guard that is not a caller's.
    pub(crate) first_guard: usize,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(expressions: &'a Expressions, first_guard: usize) -> Frame<'a> {
        Frame { expressions, variables: Scope::new(), journals: Vec::new(), first_guard }
    }
}

/// The force function that is being elaborated; its kind decides whether it may read velocities.
#[derive(Clone, Copy)]
pub(crate) struct Purpose<'a> {
    pub(crate) name: &'a str,
    pub(crate) kind: FunctionKind,
}

/// The state of an elaboration.
pub(crate) struct Elaborator<'a> {
    pub(crate) program: &'a Program<'a>,
    pub(crate) graph: Graph,
    pub(crate) diagnostics: Vec<Diagnostic>,
    pub(crate) risks: Vec<Risk>,
    /// Numbers beyond `f32`, with the positions of their expressions.
    pub(crate) extremes: Vec<(Exact, Span)>,
    /// Nodes with branches, with the innermost expressions that created them.
    pub(crate) branches: Vec<(usize, Span)>,
    /// Number of nodes that were searched for branches.
    looked_at: usize,
    pub(crate) purpose: Option<Purpose<'a>>,
    pub(crate) frame: Frame<'a>,
    /// The conditions of the open branches, each with its truth value in the branch.
    pub(crate) guards: Vec<(Truth, bool)>,
    /// Values of constants; `None` while a constant is being evaluated.
    pub(crate) constants: BTreeMap<usize, Option<Value>>,
    pub(crate) memo: FxHashMap<(usize, Vec<Value>), Value>,
    /// Functions that cannot be inlined, by index.
    pub(crate) recursive: &'a [bool],
    /// The open loops and calls, with their names in messages.
    pub(crate) open: Vec<(Span, String)>,
    /// The product of the iteration counts of the open loops of the current function.
    pub(crate) iterations: u64,
    pub(crate) exhausted: bool,
    pub(crate) depth: usize,
    steps: u64,
    limited: bool,
}

static NOTHING: std::sync::LazyLock<Expressions> = std::sync::LazyLock::new(Expressions::default);

impl<'a> Elaborator<'a> {
    pub(crate) fn new(program: &'a Program<'a>, recursive: &'a [bool], graph: Graph) -> Elaborator<'a> {
        Elaborator {
            program,
            graph,
            diagnostics: Vec::new(),
            risks: Vec::new(),
            extremes: Vec::new(),
            branches: Vec::new(),
            looked_at: 0,
            purpose: None,
            frame: Frame::new(&NOTHING, 0),
            guards: Vec::new(),
            constants: BTreeMap::new(),
            memo: FxHashMap::default(),
            recursive,
            open: Vec::new(),
            iterations: 1,
            exhausted: false,
            depth: 0,
            steps: 0,
            limited: true,
        }
    }

    /// Lifts the limit on nodes, for a graph without simplification.
    pub(crate) fn without_limit(mut self) -> Elaborator<'a> {
        self.limited = false;
        self
    }

    /// The amount of work so far, in steps.
    pub(crate) fn steps(&self) -> u64 {
        self.steps.saturating_add(self.graph.folding())
    }

    // ---- messages

    pub(crate) fn error(
        &mut self,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
    ) -> Value {
        self.diagnostics.push(Diagnostic::error(span, message, label));
        Value::Poison
    }

    pub(crate) fn error_help(
        &mut self,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
        help: Option<String>,
    ) -> Value {
        let mut diagnostic = Diagnostic::error(span, message, label);
        diagnostic.help = help;
        self.diagnostics.push(diagnostic);
        Value::Poison
    }

    /// The value if it has the wanted type, else an error; `why` says what requires the type.
    pub(crate) fn expect(&mut self, value: Value, wanted: &Type, span: Span, why: &str) -> Value {
        let found = value.ty();
        if found.agrees(wanted) {
            return value;
        }
        let help = match (&found, wanted) {
            (Type::Integer, Type::Real) => Some(self.real_help(span)),
            (Type::Real, Type::Integer) => Some(match self.program.literal(span) {
                Some(_) => "write the number without a point".to_owned(),
                None => "integers are literals, integer constants and variables of loops".to_owned(),
            }),
            (Type::Row(n), Type::Vector(m)) if n == m => Some("leave out `.transpose()`".to_owned()),
            (Type::Rotation, Type::Matrix(3)) => {
                Some("write `q.to_rotation_matrix().into_inner()`".to_owned())
            }
            (Type::Tuple(types), _) if types.is_empty() => {
                Some("end the block with an expression, without `;`".to_owned())
            }
            _ => None,
        };
        self.error_help(span, format!("expected {}, found {}", wanted.said(), found.said()), why, help)
    }

    /// The help for an integer where a real is expected.
    pub(crate) fn real_help(&self, span: Span) -> String {
        match self.program.literal(span) {
            Some(literal) => format!("write `{literal}.0`"),
            None => "write `(i as Real)` for an integer `i`".to_owned(),
        }
    }

    // ---- the budget

    /// Counts work; returns `false` once the budget is exhausted.
    pub(crate) fn spend(&mut self, steps: u64, span: Span) -> bool {
        self.steps = self.steps.saturating_add(steps);
        let nodes = self.limited && self.graph.len() > MOST_NODES;
        if !self.exhausted && (nodes || self.steps() > MOST_STEPS) {
            self.exhausted = true;
            let (span, what) = self.open.first().cloned().unwrap_or((span, "this".to_owned()));
            let label = if nodes {
                format!("{what} unrolls to more than {MOST_NODES} nodes")
            } else {
                format!("{what} takes more than {MOST_STEPS} steps to unroll")
            };
            self.error_help(
                span,
                "the function is too large",
                label,
                Some("shorten the ranges of its loops, or split it into several force functions".to_owned()),
            );
        }
        !self.exhausted
    }

    /// Evaluates an expression within the limits.
    pub(crate) fn expr(&mut self, id: ExprId) -> Value {
        let span = self.frame.expressions[id].span;
        if !self.spend(1, span) {
            return Value::Poison;
        }
        if self.depth > DEEPEST {
            self.exhausted = true;
            return self.error_help(
                span,
                "expressions and calls are nested too deeply",
                format!("more than {DEEPEST} within one another"),
                Some("name parts with `let`".to_owned()),
            );
        }
        self.depth += 1;
        let value = self.evaluate(id);
        self.depth -= 1;
        while self.looked_at < self.graph.len() {
            if self.graph.node(self.looked_at).branches() {
                self.branches.push((self.looked_at, span));
            }
            self.looked_at += 1;
        }
        let node = match value {
            Value::Real(x) => x.index(),
            Value::Vector(v) => v.index(),
            _ => return value,
        };
        if self.graph.is_beyond(node) {
            return self.out_of_range(span);
        }
        if let Value::Real(x) = value
            && self.graph.simplifies()
            && self.extremes.len() < MOST_EXTREMES
        {
            let (coefficient, rest) = self.graph.split(x);
            let number = self.graph.value(rest).cloned().unwrap_or(coefficient);
            if !number.power_stays(1) && !number.fits(Precision::F32) {
                self.extremes.push((number, span));
            }
        }
        value
    }

    /// The error for a constant that no kernel can represent.
    pub(crate) fn out_of_range(&mut self, span: Span) -> Value {
        self.error_help(
            span,
            "a constant is out of range",
            "a number here is beyond 1e±900",
            Some("choose other units, or write `(x / a).powi(n)` for a quotient of powers".to_owned()),
        )
    }

    // ---- singular expressions

    /// Records that an expression can be singular, depending on the operand.
    pub(crate) fn risk(&mut self, kind: crate::check::singular::risks::RiskKind, operand: Real, span: Span) {
        let guards = self.guards[self.frame.first_guard..].to_vec();
        self.risks.push(Risk { kind, operand, span, guards });
    }
}
