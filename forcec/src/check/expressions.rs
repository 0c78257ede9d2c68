//! Evaluates expressions, one form after the other.

use crate::check::builtins::matrices;
use crate::check::builtins::quaternions::{self};
use crate::check::elaborator::{Elaborator, LARGEST_VALUE};
use crate::check::operators;
use crate::check::program::PI;
use crate::check::types::Type;
use crate::check::values::{Composite, Value};
use crate::math::functions::Function;
use crate::source::span::Span;
use crate::source::suggest;
use crate::syntax::ast::{self, BinaryOp, ExprId, ExprKind, Name, Path, UnaryOp};
use crate::vector::Truth;

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
                for (id, literal, other) in [(*left, &x, &y), (*right, &y, &x)] {
                    let place = expressions[id].span;
                    let written = self.program.literal(place).is_some();
                    let real = !matches!(other, Value::Integer(_) | Value::Poison);
                    if matches!(literal, Value::Integer(_)) && written && real {
                        let label = format!("the other operand is {}", other.ty().said());
                        return self.expect(literal.clone(), &Type::Real, place, &label);
                    }
                }
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
        // Name resolution has reported this name.
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

    /// `&&` and `||`; the second operand is evaluated under the guard of the first.
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

    /// The value, or an error if it has more than `LARGEST_VALUE` leaves.
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
                let help = suggest::did_you_mean(&name.text, ["force", "torque"])
                    .or_else(|| Some("its fields are `force` and `torque`".to_owned()));
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
            (value, wanted) => {
                let found = value.ty();
                let help = match (&found, &wanted) {
                    (Type::Real, Type::Integer) => {
                        Some("integers are known while compiling; a kernel has reals")
                    }
                    (Type::Truth, _) => Some("write `if condition { 1.0 } else { 0.0 }`"),
                    (Type::Vector(_), Type::Real) => Some("take an entry, `v.x`, or the length, `v.norm()`"),
                    _ => None,
                };
                self.error_help(
                    span,
                    format!("{} does not become {} by `as`", found.said(), wanted.said()),
                    "`as` turns an integer into a `Real`",
                    help.map(str::to_owned),
                )
            }
        }
    }

    /// x if the condition is true, else y, for values of the same type
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
