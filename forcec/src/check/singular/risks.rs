//! Expressions whose value or derivative can be singular.
//!
//! In: risks recorded during elaboration, and the ranges of the finished graph. Out: a warning for each risk
//! that neither the stated domains, nor the form of the expression, nor the conditions of its branch exclude.

use crate::check::singular::ranges::{Interval, Ranges};
use crate::math::exact::Exact;
use crate::math::functions::{Function, FunctionDomain};
use crate::math::number::Comparison;
use crate::source::diagnostic::{Diagnostic, Lint};
use crate::source::span::Span;
use crate::vector::definition::Singular;
use crate::vector::{Graph, Node, Real, Truth};

/// An expression that can be singular.
#[derive(Clone, Debug)]
pub(crate) struct Risk {
    pub(crate) kind: RiskKind,
    /// The value that decides.
    pub(crate) operand: Real,
    pub(crate) span: Span,
    /// The conditions of the enclosing branches, each with its truth value in the branch.
    pub(crate) guards: Vec<(Truth, bool)>,
}

/// The operation that is applied to the operand.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum RiskKind {
    /// Division by the operand.
    Division,
    /// A negative power of the operand.
    NegativePower,
    /// `norm`; the operand is the returned length.
    Norm,
    /// `normalize`; the operand is the length that it divides by.
    Normalize,
    /// `inverse`; the operand is the determinant that it divides by.
    Inverse,
    /// The angle of a quaternion; the operand is the length of the imaginary part.
    Angle,
    /// The angle between two vectors; the operand is the length of their cross product.
    Parallel,
    /// A function of the operand.
    Call(Function),
    /// A power of the operand with a non-integer exponent.
    Power(AtZero),
    /// A function of two arguments that must not both be zero; the operand is the sum of their squares.
    Pair(Function),
}

/// How smooth a power is where its base is zero, depending on the exponent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum AtZero {
    /// No value: exponent below 0.
    Nothing,
    /// A value: exponent at least 0.
    Value,
    /// A derivative: exponent at least 1.
    Slope,
    /// A second derivative: exponent at least 2.
    Curvature,
}

impl AtZero {
    /// The smoothness of a power with this exponent.
    pub(crate) fn of(exponent: &Exact) -> AtZero {
        match exponent {
            y if y.is_negative() => AtZero::Nothing,
            y if *y < Exact::ONE => AtZero::Value,
            y if *y < Exact::from(2) => AtZero::Slope,
            _ => AtZero::Curvature,
        }
    }
}

/// The risks of a function that deserve a warning.
pub(crate) fn singular(graph: &Graph, ranges: &Ranges, risks: &[Risk]) -> Vec<Singular> {
    let place = |risk: &Risk| {
        let warning = warning(graph, ranges, risk)?;
        Some(Singular { operand: risk.operand, ends: risk.kind.ends(), warning, allowed: false })
    };
    risks.iter().filter_map(place).collect()
}

impl RiskKind {
    /// The values of the operand at which the expression is singular.
    fn ends(self) -> Vec<f64> {
        match self {
            RiskKind::Call(function) => match function.row().domain {
                FunctionDomain::Unit | FunctionDomain::Inside => vec![-1.0, 1.0],
                FunctionDomain::AtLeast(bound) | FunctionDomain::Above(bound) => vec![bound],
                _ => vec![0.0],
            },
            _ => vec![0.0],
        }
    }
}

fn warning(graph: &Graph, ranges: &Ranges, risk: &Risk) -> Option<Diagnostic> {
    let range = guarded(graph, ranges, risk);
    if range.low > range.high {
        // The conditions of the enclosing branches exclude each other.
        return None;
    }
    let zero = range.contains_zero();
    let always = zero && range.low == 0.0 && range.high == 0.0;
    // A value that is the same at every state has no singular derivative.
    let fixed = graph.value(risk.operand).is_some();
    let domain = "state its range with `#[domain(…)]`";
    let (message, label, help) = match risk.kind {
        RiskKind::Division | RiskKind::NegativePower if always => (
            "division by zero".to_owned(),
            "the divisor is always zero: no finite number at any state",
            "write the divisor that is meant, or leave the quotient out".to_owned(),
        ),
        RiskKind::Normalize if always => (
            "`normalize` of a vector that is always zero".to_owned(),
            "a zero vector has no direction",
            "write the vector that is meant".to_owned(),
        ),
        RiskKind::Inverse if always => (
            "`inverse` of a matrix whose determinant is always zero".to_owned(),
            "divides by the determinant",
            "write the matrix that is meant".to_owned(),
        ),
        RiskKind::Norm | RiskKind::Angle | RiskKind::Parallel | RiskKind::Pair(_) if fixed => return None,
        RiskKind::Division if zero => (
            "division by a value that can be zero".to_owned(),
            "gives no finite number where the divisor is zero",
            format!("keep the divisor away from zero, as in `x / y.max(1e-9)`, or {domain}"),
        ),
        RiskKind::NegativePower if zero => (
            "a negative power of a value that can be zero".to_owned(),
            "gives no finite number where the value is zero",
            format!("keep the value away from zero, as in `y.max(1e-9)`, or {domain}"),
        ),
        RiskKind::Norm if zero => (
            "`norm` of a vector that can be zero: its derivative divides by zero".to_owned(),
            "the length has no derivative where the vector is zero",
            "write `(v.norm_squared() + 1e-12).sqrt()`, or formulate with the vector itself".to_owned(),
        ),
        RiskKind::Normalize if zero => (
            "`normalize` of a vector that can be zero divides by zero".to_owned(),
            "a zero vector has no direction",
            "write `v / v.norm().max(1e-9)`, or state `#[domain(v = unit)]` of a parameter".to_owned(),
        ),
        RiskKind::Inverse if zero => (
            "`inverse` of a matrix whose determinant can be zero".to_owned(),
            "divides by the determinant",
            "take the inverse as a parameter, or make sure that the matrix is never singular".to_owned(),
        ),
        RiskKind::Angle if zero => (
            "`angle` of a rotation that can be the identity: its derivative divides by zero".to_owned(),
            "the angle has a kink at zero",
            "use `scaled_axis()`, which is smooth there".to_owned(),
        ),
        RiskKind::Parallel if zero => (
            "`angle` of vectors that can be parallel: its derivative divides by zero".to_owned(),
            "the angle has a kink at 0 and at π",
            "write a function of its square, which is smooth but at π, or of `u.dot(&v)`".to_owned(),
        ),
        RiskKind::Pair(function) if zero => (
            format!(
                "`{}` of values that can both be zero: its derivative divides by zero",
                function.row().name
            ),
            "no derivative where both are zero",
            "keep one of them away from zero".to_owned(),
        ),
        RiskKind::Call(function) => {
            let row = function.row();
            return call(function, [row.domain, row.smooth], "derivative", range, fixed, risk.span);
        }
        RiskKind::Power(at_zero) => {
            use FunctionDomain::{Above, AtLeast};
            let (domains, missing) = match at_zero {
                AtZero::Nothing => ([Above(0.0), Above(0.0)], "derivative"),
                AtZero::Value => ([AtLeast(0.0), Above(0.0)], "derivative"),
                AtZero::Slope => ([AtLeast(0.0), Above(0.0)], "second derivative"),
                AtZero::Curvature => ([AtLeast(0.0), AtLeast(0.0)], "derivative"),
            };
            return call(Function::Powf, domains, missing, range, fixed, risk.span);
        }
        _ => return None,
    };
    Some(Diagnostic::warning(risk.span, message, label).help(help).lint(Lint::Singular))
}

/// The warning about a function of one argument with these domains of value and derivative; `derivative`
/// names the missing derivative.
fn call(
    function: Function,
    [domain, smooth]: [FunctionDomain; 2],
    derivative: &str,
    range: Interval,
    fixed: bool,
    span: Span,
) -> Option<Diagnostic> {
    let row = function.row();
    // Set if no possible value of the operand is in the domain.
    let outside = match domain {
        FunctionDomain::AtLeast(bound) => (range.high < bound).then(|| format!("below {bound}")),
        FunctionDomain::Above(0.0) => (range.high <= 0.0).then(|| "zero or negative".to_owned()),
        FunctionDomain::Above(bound) => (range.high <= bound).then(|| format!("{bound} or below")),
        FunctionDomain::Unit => {
            (range.low > 1.0 || range.high < -1.0).then(|| "outside of -1 … 1".to_owned())
        }
        FunctionDomain::Inside => {
            (range.low >= 1.0 || range.high <= -1.0).then(|| "not between -1 and 1".to_owned())
        }
        FunctionDomain::All | FunctionDomain::NotAllZero | FunctionDomain::HalfPlane => None,
    };
    if let Some(place) = outside {
        let message = format!("`{}` of a value that is always {place}", row.name);
        let help = "write the value that is meant";
        let warning = Diagnostic::warning(span, message, "gives no finite number at any state");
        return Some(warning.help(help).lint(Lint::Singular));
    }
    let leaves = |domain: FunctionDomain| match domain {
        FunctionDomain::All => None,
        FunctionDomain::AtLeast(bound) => (range.low < bound).then(|| format!("below {bound}")),
        FunctionDomain::Above(0.0) => (range.low < 0.0 || range.contains_zero())
            .then(|| if range.low < 0.0 { "zero or negative" } else { "zero" }.to_owned()),
        FunctionDomain::Above(bound) => (range.low <= bound).then(|| format!("{bound} or below")),
        FunctionDomain::Unit => {
            (range.low < -1.0 || range.high > 1.0).then(|| "outside of -1 … 1".to_owned())
        }
        FunctionDomain::Inside => {
            (range.low <= -1.0 || range.high >= 1.0).then(|| "-1, 1 or beyond".to_owned())
        }
        FunctionDomain::NotAllZero | FunctionDomain::HalfPlane => {
            range.contains_zero().then(|| "zero".to_owned())
        }
    };
    let name = row.name;
    let (message, label) = if let Some(place) = leaves(domain) {
        (format!("`{name}` of a value that can be {place}"), "gives no finite number there".to_owned())
    } else if fixed {
        return None;
    } else if domain == FunctionDomain::Unit && (range.low <= -1.0 || range.high >= 1.0) {
        (
            format!("`{name}` of a value that can reach -1 or 1: its derivative divides by zero"),
            "no derivative there".to_owned(),
        )
    } else if let Some(place) = leaves(smooth) {
        (
            format!("`{name}` of a value that can be {place}: its {derivative} divides by zero"),
            format!("no {derivative} there"),
        )
    } else {
        return None;
    };
    let help = match function {
        Function::Acos | Function::Asin => {
            "keep it inside, as in `x.clamp(-0.999, 0.999)`, or take the angle of two vectors, `u.angle(&v)`"
                .to_owned()
        }
        Function::Atanh(_) => "keep it inside, as in `x.clamp(-0.999, 0.999)`".to_owned(),
        Function::Acosh(_) => "keep it above 1, as in `x.max(1.0 + 1e-9)`".to_owned(),
        Function::Sqrt if range.low >= 0.0 => {
            "add a positive constant, as in `(x + 1e-12).sqrt()`, or state its range with `#[domain(…)]`"
                .to_owned()
        }
        _ => "keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`".to_owned(),
    };
    Some(Diagnostic::warning(span, message, label).help(help).lint(Lint::Singular))
}

/// The range of the operand where its guards are satisfied.
fn guarded(graph: &Graph, ranges: &Ranges, risk: &Risk) -> Interval {
    let mut range = ranges.of(risk.operand);
    let (_, operand) = graph.split(risk.operand);
    let mut pending: Vec<(Truth, bool)> = risk.guards.clone();
    while let Some((truth, holds)) = pending.pop() {
        match (graph.node(truth.index()), holds) {
            (Node::Not(inner), _) => pending.push((*inner, !holds)),
            (Node::And(a, b), true) | (Node::Or(a, b), false) => {
                pending.extend([(*a, holds), (*b, holds)]);
            }
            (Node::Compare(comparison, x, y), _) => {
                for (side, other, is_left) in [(*x, *y, true), (*y, *x, false)] {
                    let bound = bound(*comparison, holds, is_left, ranges.of(other));
                    if side == risk.operand {
                        range = range.and(bound);
                    } else if side == operand || is_square_of(graph, side, operand) {
                        // The operand is a multiple of the compared value, or a length whose square is
                        // compared: only the exclusion of zero applies to the operand.
                        range.nonzero |= !ranges.of(side).and(bound).contains_zero();
                    }
                }
            }
            _ => {}
        }
    }
    range
}

/// The range that a comparison with this outcome implies for one side, given the range of the other side.
fn bound(comparison: Comparison, holds: bool, is_left: bool, other: Interval) -> Interval {
    let all = Interval::ALL;
    let below = |strict: bool| {
        let excluded = strict && other.high == 0.0 || other.high <= 0.0 && other.nonzero;
        Interval { high: other.high, nonzero: excluded || other.high < 0.0, ..all }
    };
    let above = |strict: bool| {
        let excluded = strict && other.low == 0.0 || other.low >= 0.0 && other.nonzero;
        Interval { low: other.low, nonzero: excluded || other.low > 0.0, ..all }
    };
    match (comparison, holds, is_left) {
        (Comparison::Less, true, true) => below(true),
        (Comparison::Less, true, false) => above(true),
        (Comparison::Less, false, true) => above(false),
        (Comparison::Less, false, false) => below(false),
        (Comparison::LessEqual, true, true) => below(false),
        (Comparison::LessEqual, true, false) => above(false),
        (Comparison::LessEqual, false, true) => above(true),
        (Comparison::LessEqual, false, false) => below(true),
        (Comparison::Equal, true, _) => other,
        (Comparison::Equal, false, _) => {
            let zero = other.low == 0.0 && other.high == 0.0;
            Interval { nonzero: zero, ..all }
        }
    }
}

/// Whether `square` is v·v and `length` is |v|, ignoring `let` nodes.
fn is_square_of(graph: &Graph, square: Real, length: Real) -> bool {
    let look = |mut real: Real| {
        while let Node::Let(inner) = graph.node(real.index()) {
            real = *inner;
        }
        graph.node(real.index())
    };
    matches!((look(square), look(length)), (Node::Dot(u, v), Node::Norm(w)) if u == v && v == w)
}
