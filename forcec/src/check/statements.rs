//! Blocks, `let`, assignments, loops and branches.

use crate::check::builtins::matrices::Matrix3;
use crate::check::builtins::quaternions::Quaternion;
use crate::check::elaborator::{Elaborator, MOST_ITERATIONS, Variable};
use crate::check::expressions::Condition;
use crate::check::types::Type;
use crate::check::values::{Composite, Value};
use crate::source::span::Span;
use crate::syntax::ast::{Block, ExprId, ExprKind, Loop, Pattern, Statement};
use std::collections::BTreeMap;

impl<'a> Elaborator<'a> {
    pub(super) fn block(&mut self, block: &'a Block) -> Value {
        let mark = self.frame.variables.mark();
        for statement in &block.statements {
            self.statement(statement);
        }
        let value = match block.value {
            Some(value) => self.expr(value),
            None => Value::unit(),
        };
        self.frame.variables.leave(mark);
        value
    }

    fn statement(&mut self, statement: &'a Statement) {
        let expressions = self.frame.expressions;
        match statement {
            Statement::Let { pattern, ty, value } => {
                let span = expressions[*value].span;
                let mut bound = self.expr(*value);
                if let Some(ty) = ty {
                    let wanted = self.resolve(ty);
                    let label = format!("declared as {}", wanted.said());
                    bound = self.expect(bound, &wanted, span, &label);
                }
                if bound == Value::unit() {
                    let help = match expressions[*value].kind {
                        ExprKind::If(_, _, None) => Some("add an `else` branch".to_owned()),
                        _ => Some("end the block with an expression, without `;`".to_owned()),
                    };
                    bound = self.error_help(span, "a `let` of no value", "this has no value", help);
                }
                self.bind(pattern, bound);
            }
            Statement::Assign { target, op, value, span } => self.assign(*target, *op, *value, *span),
            Statement::For(repeat) => self.repeat(repeat),
            Statement::Expr(value) => {
                self.expr(*value);
            }
        }
    }

    fn bind(&mut self, pattern: &'a Pattern, value: Value) {
        match pattern {
            Pattern::Ignore => {}
            Pattern::Name { name, .. } => {
                let value = self.named(&name.text, value, name.span);
                self.frame.variables.bind(&name.text, Variable { value });
            }
            Pattern::Tuple(patterns, span) => {
                let elements = match &value {
                    Value::Tuple(composite) | Value::Array(composite) => composite.elements.clone(),
                    Value::Poison => Vec::new(),
                    other => {
                        let said = other.ty().said();
                        let help = matches!(other, Value::Vector(_) | Value::Few(_))
                            .then(|| "take its entries by `.x`, `.y`, `.z`".to_owned());
                        self.error_help(
                            *span,
                            format!("{said} has no parts to bind"),
                            "this binds parts",
                            help,
                        );
                        Vec::new()
                    }
                };
                let fits = elements.len() == patterns.len();
                if !fits && !elements.is_empty() {
                    self.error(
                        *span,
                        format!("a pattern of {} for {} values", patterns.len(), elements.len()),
                        format!("the value is {}", value.ty().said()),
                    );
                }
                for (k, pattern) in patterns.iter().enumerate() {
                    let element = elements.get(k).filter(|_| fits).cloned().unwrap_or(Value::Poison);
                    self.bind(pattern, element);
                }
            }
        }
    }

    /// The value with each leaf bound to a `let` node of this name.
    fn named(&mut self, name: &str, value: Value, span: Span) -> Value {
        if !self.spend(value.size(), span) {
            return Value::Poison;
        }
        let g = &mut self.graph;
        match value {
            Value::Real(x) => Value::Real(g.let_real(name, x)),
            Value::Vector(v) => Value::Vector(g.let_vector(name, v)),
            Value::Few(entries) => {
                let names = ["x", "y", "z", "w"];
                let entries = entries.iter().zip(names);
                Value::Few(entries.map(|(x, axis)| g.let_real(&format!("{name}_{axis}"), *x)).collect())
            }
            Value::Matrix2(entries) => {
                let names = ["00", "01", "10", "11"];
                Value::Matrix2(std::array::from_fn(|k| {
                    g.let_real(&format!("{name}_{}", names[k]), entries[k])
                }))
            }
            Value::Matrix3(m) => {
                let line = if m.columns { 'c' } else { 'r' };
                let lines = std::array::from_fn(|k| g.let_vector(&format!("{name}_{line}{k}"), m.lines[k]));
                Value::Matrix3(Matrix3 { lines, ..m })
            }
            Value::Quat(Quaternion::Parts(parts)) => {
                let names = ["x", "y", "z", "w"];
                Value::Quat(Quaternion::Parts(std::array::from_fn(|k| {
                    g.let_real(&format!("{name}_{}", names[k]), parts[k])
                })))
            }
            Value::Wrench(force, torque) => {
                let force = g.let_vector(&format!("{name}_force"), force);
                Value::Wrench(force, g.let_vector(&format!("{name}_torque"), torque))
            }
            Value::Tuple(composite) => Value::Tuple(self.named_elements(name, &composite, span)),
            Value::Array(composite) => Value::Array(self.named_elements(name, &composite, span)),
            other => other,
        }
    }

    fn named_elements(&mut self, name: &str, composite: &Composite, span: Span) -> std::rc::Rc<Composite> {
        let elements = composite.elements.iter().enumerate();
        Composite::new(elements.map(|(k, e)| self.named(&format!("{name}_{k}"), e.clone(), span)).collect())
    }

    // ---- loops and branches

    fn repeat(&mut self, repeat: &'a Loop) {
        let ends = [repeat.start, repeat.end].map(|id| {
            let span = self.frame.expressions[id].span;
            let value = self.expr(id);
            let why = "the range of a loop is made of integer constants";
            match self.expect(value, &Type::Integer, span, why) {
                Value::Integer(n) => Some(n),
                _ => None,
            }
        });
        let (start, end) = match ends {
            [Some(start), Some(end)] => (start, end),
            _ => {
                // The body is evaluated once, so that errors in it are reported.
                self.iteration(repeat, Value::Poison);
                return;
            }
        };
        let end = if repeat.inclusive { end.saturating_add(1) } else { end };
        let count = end.saturating_sub(start);
        let outer = self.iterations;
        let total = outer.saturating_mul(count.max(0) as u64);
        if total > MOST_ITERATIONS {
            self.exhausted = true;
            let (span, what) = match self.open.first() {
                Some((span, what)) if outer > 1 => {
                    (*span, format!("{what} comes to {total} iterations or more"))
                }
                _ => (repeat.span, format!("{count} iterations")),
            };
            let label = format!("{what}; at most {MOST_ITERATIONS} can be unrolled");
            self.error_help(
                span,
                "the loop is too long to unroll",
                label,
                Some("shorten the ranges".to_owned()),
            );
            return;
        }
        let name = repeat.variable.as_ref().map_or("_", |name| &name.text);
        self.open.push((repeat.span, format!("the loop over `{name}`")));
        self.iterations = total.max(1);
        for i in start..end {
            if !self.spend(1, repeat.span) {
                break;
            }
            self.iteration(repeat, Value::Integer(i));
        }
        self.iterations = outer;
        self.open.pop();
    }

    fn iteration(&mut self, repeat: &'a Loop, i: Value) {
        let mark = self.frame.variables.mark();
        if let Some(name) = &repeat.variable {
            self.frame.variables.bind(&name.text, Variable { value: i });
        }
        let value = self.block(&repeat.body);
        if value != Value::unit() && !value.is_poison() {
            let span = repeat.body.value.map_or(repeat.body.span, |id| self.frame.expressions[id].span);
            self.error_help(
                span,
                "the body of a loop has a value",
                format!("this is {}", value.ty().said()),
                Some("assign it to a `let mut` variable, as in `sum += …;`".to_owned()),
            );
        }
        self.frame.variables.leave(mark);
    }

    pub(super) fn conditional(
        &mut self,
        condition: ExprId,
        then: &'a Block,
        otherwise: Option<ExprId>,
        span: Span,
    ) -> Value {
        let condition = match self.condition(condition) {
            Condition::Known(true) => return self.block(then),
            Condition::Known(false) => return otherwise.map_or_else(Value::unit, |id| self.expr(id)),
            Condition::Open(truth) => Some(truth),
            Condition::Poison => None,
        };
        let (first, then_stores) = self.branch(condition.map(|c| (c, true)), |e| e.block(then));
        let (second, else_stores) = self
            .branch(condition.map(|c| (c, false)), |e| otherwise.map_or_else(Value::unit, |id| e.expr(id)));
        let mut places: BTreeMap<usize, [Option<Value>; 2]> = BTreeMap::new();
        for (k, stores) in [then_stores, else_stores].into_iter().enumerate() {
            for (place, value) in stores {
                places.entry(place).or_default()[k] = Some(value);
            }
        }
        for (place, values) in places {
            let before = self.frame.variables.at(place).value.clone();
            let [x, y] = values.map(|value| value.unwrap_or_else(|| before.clone()));
            let joined = match condition {
                Some(condition) => self.select(condition, x, y, span),
                None => Value::Poison,
            };
            self.remember(place);
            self.frame.variables.at(place).value = joined;
        }
        if otherwise.is_none() && first != Value::unit() && !first.is_poison() {
            return self.error_help(
                span,
                "an `if` without `else` has no value",
                format!("its branch is {}", first.ty().said()),
                Some("add an `else` branch, or assign within the branch".to_owned()),
            );
        }
        match condition {
            Some(condition) => self.select(condition, first, second, span),
            None => Value::Poison,
        }
    }

    /// Evaluates a branch and undoes its assignments; returns its value and the assigned values.
    fn branch(
        &mut self,
        guard: Option<(crate::vector::Truth, bool)>,
        walk: impl FnOnce(&mut Self) -> Value,
    ) -> (Value, BTreeMap<usize, Value>) {
        self.guards.extend(guard);
        let mark = self.frame.variables.mark();
        self.frame.journals.push((mark, Vec::new()));
        let value = walk(self);
        let (_, journal) = self.frame.journals.pop().unwrap_or_default();
        if guard.is_some() {
            self.guards.pop();
        }
        let mut stores = BTreeMap::new();
        for (place, old) in journal.into_iter().rev() {
            let new = std::mem::replace(&mut self.frame.variables.at(place).value, old);
            stores.entry(place).or_insert(new);
        }
        (value, stores)
    }
}
