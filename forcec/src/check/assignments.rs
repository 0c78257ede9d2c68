//! Assignments to a variable or to a part of a variable.

use crate::check::builtins::matrices;
use crate::check::elaborator::Elaborator;
use crate::check::operators;
use crate::check::types::Type;
use crate::check::values::{Composite, Value};
use crate::source::span::Span;
use crate::syntax::ast::{BinaryOp, ExprId, ExprKind};

impl Elaborator<'_> {
    pub(super) fn assign(&mut self, target: ExprId, op: Option<BinaryOp>, value: ExprId, span: Span) {
        let mut new = self.expr(value);
        if let Some(op) = op {
            let old = self.expr(target);
            new = operators::binary(self, op, old, new, span);
        }
        let Some((place, steps)) = self.place(target) else { return };
        let value_span = self.frame.expressions[value].span;
        self.remember(place);
        // Moved out, so that an array without other references is changed in place.
        let old = std::mem::replace(&mut self.frame.variables.at(place).value, Value::Poison);
        let updated = self.replace(old, &steps, new, value_span);
        self.frame.variables.at(place).value = updated;
    }

    /// Journals the value of a variable before an assignment in an open branch.
    pub(super) fn remember(&mut self, place: usize) {
        if let Some((mark, journal)) = self.frame.journals.last_mut()
            && place < *mark
        {
            journal.push((place, self.frame.variables.at(place).value.clone()));
        }
    }

    /// The variable that an assignment changes, and the path to the changed part.
    fn place(&mut self, target: ExprId) -> Option<(usize, Vec<Step>)> {
        let expressions = self.frame.expressions;
        let mut steps = Vec::new();
        let mut at = target;
        loop {
            match &expressions[at].kind {
                ExprKind::Path(path) => {
                    steps.reverse();
                    return Some((self.frame.variables.find(path.single()?)?, steps));
                }
                ExprKind::Field(base, name) => {
                    steps.push(Step { kind: StepKind::Field(name.text.clone()), span: name.span });
                    at = *base;
                }
                ExprKind::Index(base, index) => {
                    let value = self.expr(*index);
                    steps.push(Step { kind: StepKind::Index(value), span: expressions[*index].span });
                    at = *base;
                }
                _ => return None,
            }
        }
    }

    /// `old` with the part at the end of the path `steps` replaced by `new`.
    fn replace(&mut self, old: Value, steps: &[Step], new: Value, span: Span) -> Value {
        let Some((step, rest)) = steps.split_first() else {
            let ty = old.ty();
            return self.expect(new, &ty, span, &format!("assigned to what is {}", ty.said()));
        };
        if old.is_poison() {
            return Value::Poison;
        }
        let k = match self.step_index(&old, step) {
            Some(k) => k,
            None => return Value::Poison,
        };
        match old {
            Value::Tuple(mut composite) => self
                .replace_element(&mut composite, k, rest, new, span)
                .map_or(Value::Poison, |()| Value::Tuple(composite)),
            Value::Array(mut composite) => self
                .replace_element(&mut composite, k, rest, new, span)
                .map_or(Value::Poison, |()| Value::Array(composite)),
            Value::Wrench(force, torque) => {
                let part = Value::Vector(if k == 0 { force } else { torque });
                match self.replace(part, rest, new, span) {
                    Value::Vector(v) if k == 0 => Value::Wrench(v, torque),
                    Value::Vector(v) => Value::Wrench(force, v),
                    _ => Value::Poison,
                }
            }
            old => {
                let new = self.expect(new, &Type::Real, span, "an entry is `Real`");
                let Value::Real(entry) = new else { return Value::Poison };
                let g = &mut self.graph;
                match old {
                    Value::Vector(v) => {
                        let mut entries = [0, 1, 2].map(|axis| g.component(v, axis));
                        entries[k] = entry;
                        Value::Vector(g.pack(entries))
                    }
                    Value::Few(mut entries) => {
                        std::rc::Rc::make_mut(&mut entries)[k] = entry;
                        Value::Few(entries)
                    }
                    Value::Matrix2(mut entries) => {
                        entries[k] = entry;
                        Value::Matrix2(entries)
                    }
                    Value::Matrix3(m) => Value::Matrix3(matrices::replaced(g, m, k / 3, k % 3, entry)),
                    _ => Value::Poison,
                }
            }
        }
    }

    fn replace_element(
        &mut self,
        composite: &mut std::rc::Rc<Composite>,
        k: usize,
        rest: &[Step],
        new: Value,
        span: Span,
    ) -> Option<()> {
        // A shared value is copied before it is changed; the copy counts as work.
        if std::rc::Rc::strong_count(composite) > 1 && !self.spend(composite.elements.len() as u64, span) {
            return None;
        }
        let elements = &mut std::rc::Rc::make_mut(composite).elements;
        let old = std::mem::replace(&mut elements[k], Value::Poison);
        let updated = self.replace(old, rest, new, span);
        if updated.is_poison() {
            return None;
        }
        elements[k] = updated;
        Some(())
    }

    /// Index of the part that a step selects, row-major for matrices.
    fn step_index(&mut self, value: &Value, step: &Step) -> Option<usize> {
        match &step.kind {
            StepKind::Field(name) => {
                let found = match value {
                    Value::Vector(_) => ["x", "y", "z"].iter().position(|axis| axis == name),
                    Value::Few(entries) => {
                        ["x", "y", "z", "w"][..entries.len()].iter().position(|axis| axis == name)
                    }
                    Value::Wrench(..) => ["force", "torque"].iter().position(|part| part == name),
                    Value::Tuple(composite) => {
                        name.parse().ok().filter(|k: &usize| *k < composite.elements.len())
                    }
                    _ => None,
                };
                if found.is_none() {
                    let said = value.ty().said();
                    let help = matches!(value, Value::Body(..)).then(|| {
                        format!("a body stays as it is; copy the field, `let mut {name} = ….{name};`")
                    });
                    self.error_help(
                        step.span,
                        format!("`{name}` cannot be assigned"),
                        format!("no such part of {said} that can change"),
                        help,
                    );
                }
                found
            }
            StepKind::Index(at) => match value {
                Value::Matrix2(_) => self.matrix_index(at, 2, step.span).map(|(i, j)| 2 * i + j),
                Value::Matrix3(_) => self.matrix_index(at, 3, step.span).map(|(i, j)| 3 * i + j),
                Value::Vector(_) => self.one_index(at, 3, step.span),
                Value::Few(entries) => self.one_index(at, entries.len(), step.span),
                Value::Array(composite) => self.one_index(at, composite.elements.len(), step.span),
                other => {
                    let said = other.ty().said();
                    self.error(
                        step.span,
                        format!("{said} cannot be indexed"),
                        format!("this indexes {said}"),
                    );
                    None
                }
            },
        }
    }
}

/// One step of the path from a variable to a part of it.
struct Step {
    kind: StepKind,
    span: Span,
}

enum StepKind {
    Field(String),
    Index(Value),
}
