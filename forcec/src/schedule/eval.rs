//! Evaluation of a schedule: statement by statement, in the order and with the association that the targets
//! print.

use crate::math::exact::Exact;
use crate::math::number::Number;
use crate::model::bodies::Slot;
use crate::model::outputs::Array;
use crate::scalar::eval::{Outputs, Value};
use crate::schedule::{Expression, Output, Part, Schedule, Statement};

impl Schedule {
    /// Evaluates every output for the given arguments; results that are added start from zero. `None` if an
    /// entry is never written, which is a defect of the schedule.
    pub fn evaluate<N: Number>(&self, inputs: &dyn Fn(Slot) -> N) -> Option<Outputs<N>> {
        let mut names: Vec<Option<Value<N>>> = vec![None; self.variables.len()];
        let mut columns: Vec<Vec<N>> = vec![Vec::new(); self.variables.len()];
        let shape = |part: &Part| part.shape(&self.signature);
        let length = |part: &Part| part.length(&self.signature);
        let zero = || N::exact(&Exact::ZERO);
        let mut outputs: Vec<Option<N>> = vec![self.adds.then(zero); self.entries()];
        // The start of each result and the length of its rows.
        let mut start = 0;
        let places: Vec<(Part, usize, usize)> = (self.parts.iter())
            .map(|part| {
                let first = start;
                start += length(part);
                (*part, first, shape(part).1)
            })
            .collect();
        let at = |part: Part, row: usize, column: usize| {
            let place = places.iter().find(|(other, ..)| *other == part);
            let &(_, first, columns) = place.expect("a schedule writes what it computes");
            first + row * columns + column
        };
        for statement in &self.statements {
            match statement {
                Statement::Let(name, value) => names[name.index()] = Some(evaluate(value, &names, inputs)?),
                Statement::Store(Output { part, row, column }, value) => {
                    outputs[at(*part, *row, *column)] = Some(evaluate(value, &names, inputs)?.real());
                }
                Statement::Add(Output { part, row, column }, negative, value) => {
                    let value = evaluate(value, &names, inputs)?.real();
                    let entry = &mut outputs[at(*part, *row, *column)];
                    *entry = Some(entry.clone()? + if *negative { -value } else { value });
                }
                Statement::Zero { part, rows, .. } => {
                    for (row, runs) in rows {
                        for column in runs.iter().cloned().flatten() {
                            outputs[at(*part, *row, column)] = Some(zero());
                        }
                    }
                }
                Statement::Columns(name, values) => {
                    let value = |x: &Expression| Some(evaluate(x, &names, inputs)?.real());
                    columns[name.index()] = values.iter().map(value).collect::<Option<_>>()?;
                }
                Statement::Scaled { part, row, factor, columns: name } => {
                    for (column, value) in columns[name.index()].iter().enumerate() {
                        let factor = evaluate(factor, &names, inputs)?.real();
                        outputs[at(*part, *row, column)] = Some(factor * value.clone());
                    }
                }
                Statement::Negated { part, rows, of, from } => {
                    for (index, row) in rows.clone().enumerate() {
                        for column in 0..shape(part).1 {
                            let value = outputs[at(*of, from + index, column)].clone()?;
                            outputs[at(*part, row, column)] = Some(-value);
                        }
                    }
                }
                Statement::Heading(..) => {}
                Statement::Leave(holds) => {
                    if evaluate(holds, &names, inputs)?.truth() {
                        outputs.fill(Some(zero()));
                        break;
                    }
                }
            }
        }
        let mut entries = outputs.into_iter();
        let mut array = |part: &Part| {
            let entries = entries.by_ref().take(length(part)).collect::<Option<_>>()?;
            Some(Array::new(*part, &self.signature, entries))
        };
        Some(Outputs(self.parts.iter().map(&mut array).collect::<Option<_>>()?))
    }
}

/// The value of an expression; `None` if a temporary has none.
pub(super) fn evaluate<N: Number>(
    expression: &Expression,
    names: &[Option<Value<N>>],
    inputs: &dyn Fn(Slot) -> N,
) -> Option<Value<N>> {
    let real = |x: &Expression| Some(evaluate(x, names, inputs)?.real());
    let truth = |x: &Expression| Some(evaluate(x, names, inputs)?.truth());
    let product = |factors: &[Expression]| -> Option<Option<N>> {
        let mut product: Option<N> = None;
        for factor in factors {
            let factor = real(factor)?;
            product = Some(match product {
                Some(product) => product * factor,
                None => factor,
            });
        }
        Some(product)
    };
    Some(Value::Real(match expression {
        Expression::Literal(value) => N::exact(value),
        Expression::Known(value) => return Some(Value::Truth(*value)),
        Expression::Input(slot) => inputs(*slot),
        Expression::Name(name) => return names[name.index()].clone(),
        Expression::Negative(x) => -real(x)?,
        Expression::Difference(pair) => real(&pair[0])? - real(&pair[1])?,
        Expression::Sum(terms) => {
            let mut sum: Option<N> = None;
            for (negative, term) in terms {
                let term = real(term)?;
                sum = Some(match (sum, negative) {
                    (None, false) => term,
                    (None, true) => -term,
                    (Some(sum), false) => sum + term,
                    (Some(sum), true) => sum - term,
                });
            }
            sum?
        }
        Expression::Quotient(over, under) => {
            let over = product(over)?.unwrap_or_else(|| N::exact(&Exact::ONE));
            match product(under)? {
                Some(under) => over / under,
                None => over,
            }
        }
        Expression::Fused(parts) => N::fused(real(&parts[0])?, real(&parts[1])?, real(&parts[2])?),
        Expression::Call(function, arguments) => {
            let arguments: Option<Vec<N>> = arguments.iter().map(real).collect();
            N::call(*function, &arguments?)
        }
        Expression::Select(parts) => real(&parts[if truth(&parts[0])? { 1 } else { 2 }])?,
        Expression::Compare(comparison, pair) => {
            return Some(Value::Truth(N::holds(*comparison, &real(&pair[0])?, &real(&pair[1])?)));
        }
        Expression::And(pair) => return Some(Value::Truth(truth(&pair[0])? && truth(&pair[1])?)),
        Expression::Or(pair) => return Some(Value::Truth(truth(&pair[0])? || truth(&pair[1])?)),
        Expression::Not(x) => return Some(Value::Truth(!truth(x)?)),
    }))
}
