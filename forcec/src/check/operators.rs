//! Unary and binary operators on values.

use crate::check::builtins::matrices::{self, Matrix3};
use crate::check::builtins::quaternions;
use crate::check::elaborator::Elaborator;
use crate::check::singular::risks::RiskKind;
use crate::check::types::Type;
use crate::check::values::Value;
use crate::math::exact::Exact;
use crate::math::number::Comparison;
use crate::source::span::Span;
use crate::syntax::ast::BinaryOp;
use crate::vector::{Graph, Node, Real};
use std::rc::Rc;

/// −x
pub(crate) fn negate(e: &mut Elaborator<'_>, value: Value, span: Span) -> Value {
    let g = &mut e.graph;
    match value {
        Value::Poison => Value::Poison,
        Value::Real(x) => Value::Real(g.neg(x)),
        Value::Integer(n) => match n.checked_neg() {
            Some(n) => Value::Integer(n),
            None => e.error(span, "an integer overflows", "beyond the range of `i64`"),
        },
        Value::Vector(v) => Value::Vector(g.vector_neg(v)),
        Value::Few(entries) => Value::Few(entries.iter().map(|x| g.neg(*x)).collect()),
        Value::Row(vector) => Value::Row(negate(e, (*vector).clone(), span).into()),
        Value::Matrix2(entries) => Value::Matrix2(entries.map(|x| g.neg(x))),
        Value::Matrix3(m) => Value::Matrix3(Matrix3 { lines: m.lines.map(|line| g.vector_neg(line)), ..m }),
        other => e.error_help(
            span,
            format!("`-` does not take {}", other.ty().said()),
            "not a number, vector or matrix",
            matches!(other, Value::Quat(_))
                .then(|| "for the opposite rotation write `q.inverse()`".to_owned()),
        ),
    }
}

/// x op y, except `&&` and `||`
pub(crate) fn binary(e: &mut Elaborator<'_>, op: BinaryOp, x: Value, y: Value, span: Span) -> Value {
    if x.is_poison() || y.is_poison() {
        return Value::Poison;
    }
    if let (Value::Integer(a), Value::Integer(b)) = (&x, &y) {
        return integers(e, op, *a, *b, span);
    }
    let result = match op {
        BinaryOp::Add => linear(&mut e.graph, 1, &x, &y),
        BinaryOp::Subtract => linear(&mut e.graph, -1, &x, &y),
        BinaryOp::Multiply => multiply(&mut e.graph, &x, &y),
        BinaryOp::Divide => divide(e, &x, &y, span),
        BinaryOp::Remainder | BinaryOp::And | BinaryOp::Or => None,
        comparison => compare(&mut e.graph, comparison, &x, &y),
    };
    match result {
        Some(value) => settle(e, value, span),
        None => mismatch(e, op, &x, &y, span),
    }
}

/// A sum or product with more terms or factors than this becomes an intermediate value.
const LONGEST_SUM: usize = 32;

/// Makes a long sum or product an intermediate value: flattening would copy every term in every iteration of
/// a loop that accumulates. Terms count as work.
fn settle(e: &mut Elaborator<'_>, value: Value, span: Span) -> Value {
    let terms = match value {
        Value::Real(x) => terms(&e.graph, x.index()),
        Value::Vector(v) => terms(&e.graph, v.index()),
        other => return other,
    };
    if terms > 2 && !e.spend(terms as u64 - 2, span) {
        return Value::Poison;
    }
    match value {
        Value::Real(x) if terms > LONGEST_SUM => Value::Real(e.graph.let_real("part", x)),
        Value::Vector(v) if terms > LONGEST_SUM => Value::Vector(e.graph.let_vector("part", v)),
        value => value,
    }
}

/// Number of terms or factors of a node, including those of the reals that scale its vectors.
fn terms(g: &Graph, index: usize) -> usize {
    match g.node(index) {
        Node::Sum(_, terms) => terms.len(),
        Node::Product(factors) => factors.len(),
        Node::Scale(s, _) => match g.node(s.index()) {
            Node::Sum(_, terms) => terms.len(),
            Node::Product(factors) => factors.len(),
            _ => 1,
        },
        Node::VectorSum(terms) => terms
            .iter()
            .map(|(_, v)| match g.node(v.index()) {
                Node::Scale(s, _) => match g.node(s.index()) {
                    Node::Sum(_, terms) => terms.len(),
                    _ => 1,
                },
                _ => 1,
            })
            .sum(),
        _ => 1,
    }
}

fn integers(e: &mut Elaborator<'_>, op: BinaryOp, a: i64, b: i64, span: Span) -> Value {
    let value = match op {
        BinaryOp::Add => a.checked_add(b),
        BinaryOp::Subtract => a.checked_sub(b),
        BinaryOp::Multiply => a.checked_mul(b),
        BinaryOp::Divide | BinaryOp::Remainder if b == 0 => {
            return e.error(span, "an integer is divided by zero", format!("{a} {} 0", op.symbol()));
        }
        BinaryOp::Divide => a.checked_div(b),
        BinaryOp::Remainder => a.checked_rem(b),
        BinaryOp::Less => return Value::Known(a < b),
        BinaryOp::LessEqual => return Value::Known(a <= b),
        BinaryOp::Greater => return Value::Known(a > b),
        BinaryOp::GreaterEqual => return Value::Known(a >= b),
        BinaryOp::Equal => return Value::Known(a == b),
        BinaryOp::NotEqual => return Value::Known(a != b),
        BinaryOp::And | BinaryOp::Or => None,
    };
    match value {
        Some(value) => Value::Integer(value),
        None => e.error(span, "an integer overflows", "beyond the range of `i64`"),
    }
}

/// x + sign y
fn linear(g: &mut Graph, sign: i64, x: &Value, y: &Value) -> Option<Value> {
    let sum = |g: &mut Graph, a: Real, b: Real| if sign == 1 { g.add(a, b) } else { g.sub(a, b) };
    let signed = Exact::from(sign);
    Some(match (x, y) {
        (Value::Real(a), Value::Real(b)) => Value::Real(sum(g, *a, *b)),
        (Value::Vector(u), Value::Vector(v)) => {
            Value::Vector(g.vector_sum(vec![(Exact::ONE, *u), (signed, *v)]))
        }
        (Value::Few(a), Value::Few(b)) if a.len() == b.len() => {
            Value::Few(a.iter().zip(b.iter()).map(|(a, b)| sum(g, *a, *b)).collect())
        }
        (Value::Row(a), Value::Row(b)) => Value::Row(Rc::new(linear(g, sign, a, b)?)),
        (Value::Matrix2(a), Value::Matrix2(b)) => Value::Matrix2(std::array::from_fn(|k| sum(g, a[k], b[k]))),
        (Value::Matrix3(a), Value::Matrix3(b)) => {
            Value::Matrix3(matrices::sum(g, (Exact::ONE, *a), (signed, *b)))
        }
        _ => return None,
    })
}

/// s x
pub(crate) fn scaled(g: &mut Graph, s: Real, x: &Value) -> Option<Value> {
    Some(match x {
        Value::Real(x) => Value::Real(g.mul(s, *x)),
        Value::Vector(v) => Value::Vector(g.scale(s, *v)),
        Value::Few(entries) => Value::Few(entries.iter().map(|x| g.mul(s, *x)).collect()),
        Value::Row(vector) => Value::Row(Rc::new(scaled(g, s, vector)?)),
        Value::Matrix2(entries) => Value::Matrix2(entries.map(|x| g.mul(s, x))),
        Value::Matrix3(m) => Value::Matrix3(matrices::scaled(g, s, *m)),
        _ => return None,
    })
}

/// x / s
pub(crate) fn quotient(g: &mut Graph, x: &Value, s: Real) -> Option<Value> {
    if g.simplifies() {
        let reciprocal = g.powi(s, -1);
        return scaled(g, reciprocal, x);
    }
    Some(match x {
        Value::Real(x) => Value::Real(g.div(*x, s)),
        Value::Vector(v) => Value::Vector(g.quotient(*v, s)),
        Value::Few(entries) => Value::Few(entries.iter().map(|x| g.div(*x, s)).collect()),
        Value::Row(vector) => Value::Row(Rc::new(quotient(g, vector, s)?)),
        Value::Matrix2(entries) => Value::Matrix2(entries.map(|x| g.div(x, s))),
        Value::Matrix3(m) => Value::Matrix3(Matrix3 { lines: m.lines.map(|line| g.quotient(line, s)), ..*m }),
        _ => return None,
    })
}

fn multiply(g: &mut Graph, x: &Value, y: &Value) -> Option<Value> {
    Some(match (x, y) {
        (Value::Real(a), Value::Real(b)) => Value::Real(g.mul(*a, *b)),
        (Value::Real(s), other) | (other, Value::Real(s)) => scaled(g, *s, other)?,
        (Value::Matrix3(m), Value::Vector(v)) => Value::Vector(matrices::times_vector(g, *m, *v)),
        (Value::Matrix3(a), Value::Matrix3(b)) => Value::Matrix3(matrices::product(g, *a, *b)),
        (Value::Matrix2(m), Value::Few(v)) if v.len() == 2 => {
            Value::Few([0, 2].map(|start| inner(g, &m[start..start + 2], v)).into())
        }
        (Value::Matrix2(a), Value::Matrix2(b)) => Value::Matrix2([0, 1, 2, 3].map(|k| {
            let (row, column) = (k / 2, k % 2);
            inner(g, &a[2 * row..2 * row + 2], &[b[column], b[2 + column]])
        })),
        (Value::Quat(q) | Value::Rotation(q), Value::Vector(v)) => {
            Value::Vector(quaternions::rotate(g, q, *v))
        }
        (Value::Quat(p), Value::Quat(q)) => Value::Quat(quaternions::product(g, p, q)),
        (Value::Rotation(p), Value::Rotation(q)) => Value::Rotation(quaternions::product(g, p, q)),
        // u vᵀ
        (Value::Vector(u), Value::Row(v)) if matches!(**v, Value::Vector(_)) => {
            Value::Matrix3(matrices::outer(g, *u, v.vector()))
        }
        (Value::Few(u), Value::Row(v)) if u.len() == 2 => match &**v {
            Value::Few(v) if v.len() == 2 => Value::Matrix2([0, 1, 2, 3].map(|k| g.mul(u[k / 2], v[k % 2]))),
            _ => return None,
        },
        // uᵀ A = (Aᵀ u)ᵀ
        (Value::Row(u), Value::Matrix3(m)) if matches!(**u, Value::Vector(_)) => {
            let product = matrices::times_vector(g, m.transpose(), u.vector());
            Value::Row(Rc::new(Value::Vector(product)))
        }
        (Value::Row(u), Value::Matrix2(m)) => match &**u {
            Value::Few(u) if u.len() == 2 => {
                let entries = [0, 1].map(|k| inner(g, u, &[m[k], m[2 + k]]));
                Value::Row(Rc::new(Value::Few(entries.into())))
            }
            _ => return None,
        },
        _ => return None,
    })
}

/// Σ xᵢ yᵢ
pub(crate) fn inner(g: &mut Graph, x: &[Real], y: &[Real]) -> Real {
    let terms = x.iter().zip(y).map(|(x, y)| (Exact::ONE, g.mul(*x, *y))).collect();
    g.sum(Exact::ZERO, terms)
}

fn divide(e: &mut Elaborator<'_>, x: &Value, y: &Value, span: Span) -> Option<Value> {
    match (x, y) {
        (Value::Quat(p), Value::Quat(q)) => {
            let inverse = quaternions::inverse(&mut e.graph, q);
            Some(Value::Quat(quaternions::product(&mut e.graph, p, &inverse)))
        }
        (Value::Real(x), Value::Real(y)) => {
            e.risk(RiskKind::Division, *y, span);
            Some(Value::Real(e.graph.div(*x, *y)))
        }
        (x, Value::Real(y)) => {
            let quotient = quotient(&mut e.graph, x, *y)?;
            e.risk(RiskKind::Division, *y, span);
            Some(quotient)
        }
        _ => None,
    }
}

fn compare(g: &mut Graph, op: BinaryOp, x: &Value, y: &Value) -> Option<Value> {
    let (Value::Real(x), Value::Real(y)) = (x, y) else { return None };
    let (comparison, x, y) = match op {
        BinaryOp::Less => (Comparison::Less, x, y),
        BinaryOp::Greater => (Comparison::Less, y, x),
        BinaryOp::LessEqual => (Comparison::LessEqual, x, y),
        BinaryOp::GreaterEqual => (Comparison::LessEqual, y, x),
        _ => (Comparison::Equal, x, y),
    };
    let truth = g.compare(comparison, *x, *y);
    Some(Value::Truth(if op == BinaryOp::NotEqual { g.not(truth) } else { truth }))
}

/// The error for operands of incompatible types.
fn mismatch(e: &mut Elaborator<'_>, op: BinaryOp, x: &Value, y: &Value, span: Span) -> Value {
    let (left, right) = (x.ty(), y.ty());
    let (message, label) = if left == right {
        (format!("`{}` does not take {}", op.symbol(), left.said()), format!("both are {}", left.said()))
    } else {
        (
            format!("`{}` does not take {} and {}", op.symbol(), left.said(), right.said()),
            format!("{} on the left, {} on the right", left.said(), right.said()),
        )
    };
    let help = match (op, &left, &right) {
        (_, Type::Integer, _) | (_, _, Type::Integer) => Some("write `(i as Real)` for an integer `i`"),
        (BinaryOp::Multiply, Type::Vector(_), Type::Vector(_)) => Some(
            "for the inner product write `u.dot(&v)`, for the vector product `u.cross(&v)`, entry by entry `u.component_mul(&v)`",
        ),
        (BinaryOp::Multiply, Type::Row(_), Type::Vector(_)) => {
            Some("for the inner product write `u.dot(&v)`")
        }
        (BinaryOp::Multiply, Type::Vector(_), Type::Quat | Type::Matrix(_)) => {
            Some("the rotation or matrix stands on the left, `m * v`")
        }
        (BinaryOp::Multiply, Type::Quat, Type::Matrix(_))
        | (BinaryOp::Multiply, Type::Matrix(_), Type::Quat) => {
            Some("turn the quaternion into a matrix by `q.to_rotation_matrix().into_inner()`")
        }
        (BinaryOp::Multiply, Type::Truth, _) | (BinaryOp::Multiply, _, Type::Truth) => {
            Some("write `if condition { x } else { 0.0 }`")
        }
        (BinaryOp::Multiply, Type::Matrix(_), Type::Matrix(_) | Type::Vector(_)) => {
            Some("a matrix is multiplied with what has as many rows as it has columns")
        }
        (BinaryOp::Add | BinaryOp::Subtract, Type::Quat, _)
        | (BinaryOp::Multiply | BinaryOp::Divide, Type::Quat, Type::Real)
        | (BinaryOp::Multiply, Type::Real, Type::Quat) => {
            Some("turns follow each other by `p * q`; a vector to calculate with is `q.scaled_axis()`")
        }
        (BinaryOp::Divide, _, Type::Vector(_)) => {
            Some("divide entry by entry, `Vec3::new(u.x / v.x, u.y / v.y, u.z / v.z)`")
        }
        (BinaryOp::Divide, _, Type::Matrix(_)) => Some("multiply by `m.inverse()`"),
        (BinaryOp::Remainder, _, _) => Some("`%` is for integers; reals have no remainder here"),
        (BinaryOp::Equal | BinaryOp::NotEqual, _, _) => Some("compare reals, entry by entry"),
        (BinaryOp::Add | BinaryOp::Subtract, Type::Vector(_), Type::Real) => {
            Some("for a vector with the number in every entry write `Vec3::new(x, x, x)`")
        }
        (
            BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual,
            Type::Vector(_),
            _,
        ) => Some("compare lengths, `v.norm()`, or entries, `v.x`"),
        (_, Type::Body(_), _) | (_, _, Type::Body(_)) => {
            Some("take a field of the body, such as `.position`")
        }
        _ => None,
    };
    e.error_help(span, message, label, help.map(str::to_owned))
}
