//! Expressions, one form after the other.

use super::elaborator::{Elaborator, LARGEST_VALUE};
use super::matrices;
use super::operators;
use super::program::PI;
use super::quaternions::{self, Quaternion};
use super::types::Type;
use super::values::{Composite, Value};
use crate::bodies::Role;
use crate::ops::Function;
use crate::span::Span;
use crate::syntax::ast::{self, BinaryOp, ExprId, ExprKind, FunctionKind, Name, Path, TypeKind, UnaryOp};
use crate::syntax::suggest;
use crate::vector::{Real, Truth};

/// What follows a condition.
#[derive(Clone, Copy)]
pub(crate) enum Condition {
    Known(bool),
    Open(Truth),
    Poison,
}

impl<'a> Elaborator<'a> {
    pub(super) fn evaluate(&mut self, id: ExprId) -> Value {
        let expressions = self.frame.expressions;
        let expr = &expressions[id];
        let span = expr.span;
        match &expr.kind {
            ExprKind::Number(value) => Value::Real(self.graph.constant(value.clone())),
            ExprKind::Integer(value) => Value::Integer(*value),
            ExprKind::Truth(value) => Value::Known(*value),
            ExprKind::Path(path) => self.path(path),
            ExprKind::Unary(op, operand) => self.unary(*op, *operand, span),
            ExprKind::Binary(op @ (BinaryOp::And | BinaryOp::Or), left, right) => {
                self.logical(*op, *left, *right)
            }
            ExprKind::Binary(op, left, right) => {
                let (x, y) = (self.expr(*left), self.expr(*right));
                operators::binary(self, *op, x, y, span)
            }
            ExprKind::Call(path, arguments) => self.call(path, arguments, span),
            ExprKind::Method(receiver, name, arguments) => self.method(*receiver, name, arguments, span),
            ExprKind::Field(base, name) => {
                let base = self.expr(*base);
                self.field(base, name)
            }
            ExprKind::Index(base, index) => {
                let base = self.expr(*base);
                let at = self.expr(*index);
                self.index(base, at, span, expressions[*index].span)
            }
            ExprKind::Tuple(elements) => {
                let elements = elements.iter().map(|element| self.expr(*element)).collect();
                let tuple = Value::tuple(elements);
                self.sized(tuple, span)
            }
            ExprKind::Array(elements) => self.array(elements, span),
            ExprKind::Repeat(element, length) => {
                let element = self.expr(*element);
                let length = self.array_length(*length);
                let (false, Some(length)) = (element.is_poison(), length) else { return Value::Poison };
                if element.size().saturating_mul(u64::from(length)) > LARGEST_VALUE {
                    return self.too_large(span);
                }
                if !self.spend(u64::from(length), span) {
                    return Value::Poison;
                }
                Value::array(vec![element; length as usize])
            }
            ExprKind::Struct(path, fields) => self.wrench(path, fields, span),
            ExprKind::Cast(value, ty) => {
                let value = self.expr(*value);
                self.cast(value, ty, span)
            }
            ExprKind::Block(block) => self.block(block),
            ExprKind::If(condition, then, otherwise) => self.conditional(*condition, then, *otherwise, span),
            ExprKind::Error => Value::Poison,
        }
    }

    fn path(&mut self, path: &Path) -> Value {
        if let Some(place) = path.single().and_then(|name| self.frame.variables.find(name)) {
            return self.frame.variables.at(place).value.clone();
        }
        if let Some(index) = self.program.constant(path.last()) {
            return self.constant(index);
        }
        if path.last() == PI {
            return Value::Real(self.graph.call(Function::Pi, &[]));
        }
        // The walk over names has said so.
        Value::Poison
    }

    fn unary(&mut self, op: UnaryOp, operand: ExprId, span: Span) -> Value {
        let value = self.expr(operand);
        match op {
            UnaryOp::Negate => operators::negate(self, value, span),
            UnaryOp::Not => match value {
                Value::Known(truth) => Value::Known(!truth),
                Value::Truth(truth) => Value::Truth(self.graph.not(truth)),
                Value::Poison => Value::Poison,
                other => self.error_help(
                    span,
                    format!("`!` does not take {}", other.ty().said()),
                    "not a condition",
                    (other.ty() == Type::Real).then(|| "for the opposite number write `-x`".to_owned()),
                ),
            },
        }
    }

    /// A condition.
    pub(super) fn condition(&mut self, id: ExprId) -> Condition {
        let span = self.frame.expressions[id].span;
        let value = self.expr(id);
        match self.expect(
            value,
            &Type::Truth,
            span,
            "a condition is a comparison, or several joined by `&&` and `||`",
        ) {
            Value::Known(truth) => Condition::Known(truth),
            Value::Truth(truth) => Condition::Open(truth),
            _ => Condition::Poison,
        }
    }

    /// `&&` and `||`: the second operand counts only where the first leaves it open.
    fn logical(&mut self, op: BinaryOp, left: ExprId, right: ExprId) -> Value {
        let decided = op == BinaryOp::Or;
        let first = match self.condition(left) {
            Condition::Known(truth) if truth == decided => return Value::Known(truth),
            first => first,
        };
        if let Condition::Open(truth) = first {
            self.guards.push((truth, !decided));
        }
        let second = self.condition(right);
        if let Condition::Open(_) = first {
            self.guards.pop();
        }
        match (first, second) {
            (Condition::Poison, _) | (_, Condition::Poison) => Value::Poison,
            (_, Condition::Known(truth)) if truth == decided => Value::Known(truth),
            (Condition::Known(_), Condition::Known(truth)) => Value::Known(truth),
            (Condition::Known(_), Condition::Open(truth)) | (Condition::Open(truth), Condition::Known(_)) => {
                Value::Truth(truth)
            }
            (Condition::Open(x), Condition::Open(y)) => {
                Value::Truth(if decided { self.graph.or(x, y) } else { self.graph.and(x, y) })
            }
        }
    }

    // ---- parts

    pub(super) fn field(&mut self, base: Value, name: &Name) -> Value {
        const AXES: [&str; 4] = ["x", "y", "z", "w"];
        let text = name.text.as_str();
        let axis = AXES.iter().position(|axis| *axis == text);
        match (&base, axis) {
            (Value::Poison, _) => return Value::Poison,
            (Value::Vector(v), Some(axis @ 0..3)) => {
                return Value::Real(self.graph.component(*v, axis as u8));
            }
            (Value::Few(entries), Some(axis)) if axis < entries.len() => return Value::Real(entries[axis]),
            (Value::Quat(q), _) => {
                if let Some(part) = ["i", "j", "k", "w"].iter().position(|part| *part == text) {
                    let parts = quaternions::parts(&mut self.graph, q);
                    return Value::Real(parts[part]);
                }
            }
            (Value::Wrench(force, torque), _) => match text {
                "force" => return Value::Vector(*force),
                "torque" => return Value::Vector(*torque),
                _ => {}
            },
            (Value::Tuple(composite), _) => {
                if let Some(element) = text.parse().ok().and_then(|k: usize| composite.elements.get(k)) {
                    return element.clone();
                }
            }
            (Value::Body(body, kind), _) => {
                if let Some(field) = kind.row().fields.iter().find(|field| field.name == text) {
                    return self.body_field(*body, field.role, name.span);
                }
            }
            _ => {}
        }
        let known: Vec<&str> = match &base {
            Value::Vector(_) => AXES[..3].to_vec(),
            Value::Few(entries) => AXES[..entries.len()].to_vec(),
            Value::Quat(_) => vec!["i", "j", "k", "w"],
            Value::Wrench(..) => vec!["force", "torque"],
            Value::Body(_, kind) => kind.row().fields.iter().map(|field| field.name).collect(),
            _ => Vec::new(),
        };
        let ty = base.ty();
        let help = match (&base, axis) {
            (Value::Quat(_), Some(_)) => {
                Some("the parts of a quaternion are `i`, `j`, `k` and `w`".to_owned())
            }
            (Value::Tuple(composite), _) => {
                Some(format!("the tuple has {} elements, counted from 0", composite.elements.len()))
            }
            (Value::Array(_), _) => Some("write `array[0]` for an element".to_owned()),
            (Value::Matrix2(_) | Value::Matrix3(_), _) => {
                Some("write `m[(row, column)]` for an entry".to_owned())
            }
            _ => suggest::did_you_mean(text, known.iter().copied()).or_else(|| {
                let method = super::builtins::method_arguments(text) == Some(0);
                match known.as_slice() {
                    _ if method => Some(format!("`{text}` is a method; write `.{text}()`")),
                    [] => None,
                    known => Some(format!("its fields are `{}`", known.join("`, `"))),
                }
            }),
        };
        self.error_help(
            name.span,
            format!("unknown field `{text}`"),
            format!("no such field on {}", ty.said()),
            help,
        )
    }

    fn body_field(&mut self, body: u16, role: Role, span: Span) -> Value {
        if let (Role::Velocity | Role::AngularVelocity, Some(purpose)) = (role, self.purpose) {
            let what = match purpose.kind {
                FunctionKind::Constraint { .. } => {
                    Some(("constraint", "damping is added to every constraint"))
                }
                FunctionKind::Energy => Some(("energy", "for a force that depends on velocity")),
                FunctionKind::Force | FunctionKind::Helper => None,
            };
            if let Some((what, _)) = what {
                let help = if what == "constraint" {
                    "leave it to the `damping` of the constraint, or write a `#[force]`"
                } else {
                    "write a `#[force]` beside the energy"
                };
                return self.error_help(
                    span,
                    format!("{} {what} reads a velocity", if what == "energy" { "an" } else { "a" }),
                    format!("`{}` may depend on positions and orientations only", purpose.name),
                    Some(help.to_owned()),
                );
            }
        }
        let Some(slot) = self.graph.signature.body_slot(body, role) else { return Value::Poison };
        match role {
            Role::Orientation => Value::Quat(Quaternion::stored(slot)),
            _ => Value::Vector(self.graph.triple(slot)),
        }
    }

    pub(super) fn index(&mut self, base: Value, at: Value, span: Span, at_span: Span) -> Value {
        if base.is_poison() || at.is_poison() {
            return Value::Poison;
        }
        let found = match &base {
            Value::Matrix2(_) | Value::Matrix3(_) => {
                let n = if matches!(base, Value::Matrix2(_)) { 2 } else { 3 };
                let Some((row, column)) = self.matrix_index(&at, n, at_span) else { return Value::Poison };
                return Value::Real(self.matrix_entry(&base, row, column));
            }
            Value::Vector(_) => 3,
            Value::Few(entries) => entries.len(),
            Value::Array(composite) => composite.elements.len(),
            Value::Row(_) => 0,
            other => {
                let help = match other {
                    Value::Tuple(_) => Some("write `.0`, `.1` for the elements of a tuple".to_owned()),
                    Value::Quat(_) => Some("the parts of a quaternion are `i`, `j`, `k` and `w`".to_owned()),
                    _ => None,
                };
                let said = other.ty().said();
                return self.error_help(
                    span,
                    format!("{said} cannot be indexed"),
                    format!("this is {said}"),
                    help,
                );
            }
        };
        let Some(k) = self.one_index(&at, found, at_span) else { return Value::Poison };
        match &base {
            Value::Vector(v) => Value::Real(self.graph.component(*v, k as u8)),
            Value::Few(entries) => Value::Real(entries[k]),
            Value::Array(composite) => composite.elements[k].clone(),
            _ => Value::Poison,
        }
    }

    /// An index below a length.
    pub(super) fn one_index(&mut self, at: &Value, length: usize, span: Span) -> Option<usize> {
        let Value::Integer(k) = at else {
            let said = at.ty().said();
            let help = match at {
                Value::Real(_) => Some("write an integer, `0`, or the variable of a loop".to_owned()),
                _ => None,
            };
            if !at.is_poison() {
                self.error_help(
                    span,
                    format!("an index is an integer, not {said}"),
                    format!("this is {said}"),
                    help,
                );
            }
            return None;
        };
        match usize::try_from(*k) {
            Ok(k) if k < length => Some(k),
            _ => {
                self.error(
                    span,
                    "an index out of range",
                    format!("{k} is not among 0 to {}", length.saturating_sub(1)),
                );
                None
            }
        }
    }

    /// A row and a column below n.
    pub(super) fn matrix_index(&mut self, at: &Value, n: usize, span: Span) -> Option<(usize, usize)> {
        match at {
            Value::Tuple(pair) if pair.elements.len() == 2 => {
                let row = self.one_index(&pair.elements[0], n, span)?;
                Some((row, self.one_index(&pair.elements[1], n, span)?))
            }
            other => {
                let said = other.ty().said();
                self.error_help(
                    span,
                    "a matrix is indexed by row and column",
                    format!("this is {said}"),
                    Some("write `m[(row, column)]`".to_owned()),
                );
                None
            }
        }
    }

    pub(super) fn matrix_entry(&mut self, matrix: &Value, row: usize, column: usize) -> Real {
        match matrix {
            Value::Matrix2(entries) => entries[2 * row + column],
            Value::Matrix3(m) => matrices::entry(&mut self.graph, *m, row, column),
            other => unreachable!("checked to be a matrix: {other:?}"),
        }
    }

    // ---- composites

    fn array(&mut self, elements: &[ExprId], span: Span) -> Value {
        let expressions = self.frame.expressions;
        let values: Vec<Value> = elements.iter().map(|element| self.expr(*element)).collect();
        let Some(first) = values.first() else {
            return self.error(span, "an empty array", "its type is not known");
        };
        let ty = first.ty();
        for (value, id) in values.iter().zip(elements) {
            if !value.ty().agrees(&ty) {
                let label = format!("the first element is {}", ty.said());
                return self.expect(value.clone(), &ty, expressions[*id].span, &label);
            }
        }
        let array = Value::array(values);
        self.sized(array, span)
    }

    /// The value, unless it is larger than any kernel needs.
    fn sized(&mut self, value: Value, span: Span) -> Value {
        if value.size() > LARGEST_VALUE { self.too_large(span) } else { value }
    }

    fn too_large(&mut self, span: Span) -> Value {
        self.error(span, "a value is too large", format!("it has more than {LARGEST_VALUE} entries"))
    }

    fn wrench(&mut self, path: &Path, fields: &[(Name, ExprId)], span: Span) -> Value {
        let expressions = self.frame.expressions;
        if path.last() != "Wrench" {
            let help = suggest::did_you_mean(path.last(), ["Wrench"])
                .unwrap_or_else(|| "the one struct is `Wrench { force, torque }`".to_owned());
            return self.error_help(
                path.span,
                format!("unknown struct `{}`", path.last()),
                "no struct of this name",
                Some(help),
            );
        }
        let mut parts: [Option<Value>; 2] = [None, None];
        let mut wrong = false;
        for (name, id) in fields {
            let value = self.expr(*id);
            let value = self.expect(
                value,
                &Type::Vector(3),
                expressions[*id].span,
                &format!("`{}` of a wrench is a vector of three", name.text),
            );
            let Some(k) = ["force", "torque"].iter().position(|known| *known == name.text) else {
                let help = suggest::did_you_mean(&name.text, ["force", "torque"]);
                self.error_help(
                    name.span,
                    format!("unknown field `{}`", name.text),
                    "no such field on `Wrench`",
                    help,
                );
                wrong = true;
                continue;
            };
            if parts[k].is_some() {
                self.error(name.span, format!("`{}` is given twice", name.text), "the second time");
                wrong = true;
            }
            parts[k] = Some(value);
        }
        match parts {
            [Some(Value::Vector(force)), Some(Value::Vector(torque))] => Value::Wrench(force, torque),
            [force, torque] => {
                if !wrong && (force.is_none() || torque.is_none()) {
                    let missing = if force.is_none() { "force" } else { "torque" };
                    self.error_help(
                        span,
                        format!("a wrench without `{missing}`"),
                        "both of its fields have to be given",
                        Some(
                            "write `Wrench { force, torque }`; `Vec3::zeros()` where there is none"
                                .to_owned(),
                        ),
                    );
                }
                Value::Poison
            }
        }
    }

    fn cast(&mut self, value: Value, ty: &ast::Type, span: Span) -> Value {
        let wanted = self.resolve(ty);
        match (value, wanted) {
            (Value::Poison, _) | (_, Type::Poison) => Value::Poison,
            (Value::Integer(n), Type::Real) => Value::Real(self.graph.constant(n.into())),
            (value @ Value::Integer(_), Type::Integer) | (value @ Value::Real(_), Type::Real) => value,
            (value, wanted) => self.error_help(
                span,
                format!("{} does not become {} by `as`", value.ty().said(), wanted.said()),
                "`as` turns an integer into a `Real`",
                None,
            ),
        }
    }

    // ---- types and lengths

    /// The type a text names.
    pub(crate) fn resolve(&mut self, ty: &ast::Type) -> Type {
        match &ty.kind {
            TypeKind::Error => Type::Poison,
            TypeKind::Tuple(types) => Type::Tuple(types.iter().map(|ty| self.resolve(ty)).collect()),
            TypeKind::Array(element, length) => {
                let element = self.resolve(element);
                match self.array_length(*length) {
                    Some(length) => Type::Array(Box::new(element), length),
                    None => Type::Poison,
                }
            }
            TypeKind::Named(name) => {
                if let Some(known) = Type::named(name) {
                    return known;
                }
                let other = crate::syntax::OTHER_NAMES.iter().find(|(other, _)| other == name);
                let help = match other {
                    Some((_, ours)) => Some(format!("write `{ours}`")),
                    None => suggest::did_you_mean(name, Type::names()),
                };
                self.error_help(
                    ty.span,
                    format!("unknown type `{name}`"),
                    "no type of the force language",
                    help,
                );
                Type::Poison
            }
        }
    }

    /// The length of an array, at least one.
    pub(super) fn array_length(&mut self, id: ExprId) -> Option<u32> {
        let span = self.frame.expressions[id].span;
        let value = self.expr(id);
        match self.expect(value, &Type::Integer, span, "the length of an array is an integer constant") {
            Value::Integer(n) if n >= 1 && n as u64 <= LARGEST_VALUE => Some(n as u32),
            Value::Integer(n) => {
                self.error(span, "a length out of range", format!("{n} is not among 1 to {LARGEST_VALUE}"));
                None
            }
            _ => None,
        }
    }

    /// if the condition holds x, else y, for values of any type that the two share
    pub(super) fn select(&mut self, condition: Truth, x: Value, y: Value, span: Span) -> Value {
        let g = &mut self.graph;
        match (&x, &y) {
            (Value::Poison, _) | (_, Value::Poison) => Value::Poison,
            _ if x == y => x,
            (Value::Real(a), Value::Real(b)) => Value::Real(g.select(condition, *a, *b)),
            (Value::Vector(a), Value::Vector(b)) => Value::Vector(g.vector_select(condition, *a, *b)),
            (Value::Few(a), Value::Few(b)) if a.len() == b.len() => {
                Value::Few(a.iter().zip(b.iter()).map(|(a, b)| g.select(condition, *a, *b)).collect())
            }
            (Value::Row(a), Value::Row(b)) => {
                let (a, b) = ((**a).clone(), (**b).clone());
                match self.select(condition, a, b, span) {
                    Value::Poison => Value::Poison,
                    vector => Value::Row(vector.into()),
                }
            }
            (Value::Matrix2(a), Value::Matrix2(b)) => {
                Value::Matrix2(std::array::from_fn(|k| g.select(condition, a[k], b[k])))
            }
            (Value::Matrix3(a), Value::Matrix3(b)) => Value::Matrix3(matrices::select(g, condition, *a, *b)),
            (Value::Quat(a), Value::Quat(b)) => Value::Quat(quaternions::select(g, condition, a, b)),
            (Value::Rotation(a), Value::Rotation(b)) => {
                Value::Rotation(quaternions::select(g, condition, a, b))
            }
            (Value::Wrench(f, t), Value::Wrench(g2, t2)) => {
                let force = g.vector_select(condition, *f, *g2);
                Value::Wrench(force, g.vector_select(condition, *t, *t2))
            }
            (Value::Truth(_) | Value::Known(_), Value::Truth(_) | Value::Known(_)) => {
                // (c ∧ x) ∨ (¬c ∧ y)
                let (a, b) = (self.truth_node(&x), self.truth_node(&y));
                let not = self.graph.not(condition);
                let first = self.graph.and(condition, a);
                let second = self.graph.and(not, b);
                Value::Truth(self.graph.or(first, second))
            }
            (Value::Tuple(a), Value::Tuple(b)) | (Value::Array(a), Value::Array(b))
                if a.elements.len() == b.elements.len() && x.ty() == y.ty() =>
            {
                if !self.spend(a.size, span) {
                    return Value::Poison;
                }
                let pairs = a.elements.clone().into_iter().zip(b.elements.clone());
                let elements: Vec<Value> = pairs.map(|(a, b)| self.select(condition, a, b, span)).collect();
                if elements.contains(&Value::Poison) {
                    return Value::Poison;
                }
                let composite = Composite::new(elements);
                if matches!(x, Value::Tuple(_)) { Value::Tuple(composite) } else { Value::Array(composite) }
            }
            _ if x.ty() == y.ty() => self.error(
                span,
                format!("which {} it is has to be known while compiling", x.ty().said()),
                "the condition depends on bodies or parameters",
            ),
            _ => self.error(
                span,
                "the branches have different types",
                format!("{} and {}", x.ty().said(), y.ty().said()),
            ),
        }
    }

    fn truth_node(&mut self, value: &Value) -> Truth {
        match value {
            Value::Truth(truth) => *truth,
            Value::Known(known) => self.graph.known(*known),
            other => unreachable!("checked to be a truth: {other:?}"),
        }
    }
}
