//! Parts of values: fields of bodies, entries of vectors and matrices, elements of tuples and arrays.

use crate::check::builtins::matrices;
use crate::check::builtins::quaternions::{self, Quaternion};
use crate::check::elaborator::Elaborator;
use crate::check::values::Value;
use crate::model::bodies::Role;
use crate::source::span::Span;
use crate::source::suggest;
use crate::syntax::ast::{FunctionKind, Name};
use crate::vector::Real;

impl Elaborator<'_> {
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
            (Value::Quat(_), Some(axis)) => Some(format!(
                "the parts of a quaternion are `i`, `j`, `k` and `w`; write `.{}`",
                ["i", "j", "k", "w"][axis]
            )),
            (Value::Tuple(composite), _) => {
                Some(format!("the tuple has {} elements, counted from 0", composite.elements.len()))
            }
            (Value::Array(_), _) => Some("write `array[0]` for an element".to_owned()),
            (Value::Matrix2(_) | Value::Matrix3(_), _) => {
                Some("write `m[(row, column)]` for an entry".to_owned())
            }
            (Value::Body(..), _) if instead_of_field(text).is_some() => {
                instead_of_field(text).map(|field| match known.contains(&field) {
                    true => format!("write `.{field}`"),
                    false if field.is_empty() => "take it as a parameter".to_owned(),
                    false => format!("{} has no {field}, a `Rigid` has", ty.said()),
                })
            }
            _ => suggest::did_you_mean(text, known.iter().copied()).or_else(|| {
                let method = crate::check::builtins::method_arguments(text) == Some(0);
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

    /// Checks that `at` is an index below `length`.
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

    /// Checks that `at` is a pair of indices below `n`.
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
}

/// The body field that others call `name`; empty for a quantity that no body has.
fn instead_of_field(name: &str) -> Option<&'static str> {
    Some(match name {
        "pos" | "translation" | "center" | "centre" => "position",
        "rotation" | "rot" | "quat" | "orientation" => "orientation",
        "vel" | "linvel" | "linear_velocity" => "velocity",
        "omega" | "angvel" | "angular_velocity" => "angular_velocity",
        "mass" | "inertia" | "radius" | "force" | "torque" | "acceleration" => "",
        _ => return None,
    })
}
