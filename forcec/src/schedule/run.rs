//! A schedule evaluated: statement by statement, in the order and with the association that the targets print.

use crate::bodies::Slot;
use crate::eval::{Outputs, Value};
use crate::exact::Exact;
use crate::number::Number;
use crate::schedule::{Expression, Output, Part, Schedule, Statement};

impl Schedule {
    /// Every output, given the arguments. `None` if some entry is never written: a defect of the schedule.
    pub fn evaluate<N: Number>(&self, inputs: &dyn Fn(Slot) -> N) -> Option<Outputs<N>> {
        let count = self.signature.freedoms();
        let mut names: Vec<Option<Value<N>>> = vec![None; self.variables.len()];
        let mut force: Vec<Option<N>> = vec![None; count];
        let mut matrices: [Vec<Vec<Option<N>>>; 2] = std::array::from_fn(|_| vec![vec![None; count]; count]);
        let mut store = |output: Output, value: N| {
            let entry = match output.part {
                Part::Force => &mut force[output.row],
                Part::Dfdx => &mut matrices[0][output.row][output.column],
                Part::Dfdv => &mut matrices[1][output.row][output.column],
            };
            *entry = Some(value);
        };
        for statement in &self.statements {
            match statement {
                Statement::Let(name, value) => names[name.index()] = Some(evaluate(value, &names, inputs)?),
                Statement::Store(output, value) => store(*output, evaluate(value, &names, inputs)?.real()),
                Statement::Zero { part, rows, columns } => {
                    for row in rows.clone() {
                        for column in columns.iter().cloned().flatten() {
                            store(Output::new(*part, row, column), N::exact(&Exact::ZERO));
                        }
                    }
                }
                Statement::Heading(_) => {}
            }
        }
        let [dfdx, dfdv] = matrices;
        let written = |row: Vec<Option<N>>| row.into_iter().collect::<Option<Vec<N>>>();
        let matrix = |rows: Vec<Vec<Option<N>>>| rows.into_iter().map(written).collect::<Option<Vec<_>>>();
        Some(Outputs { force: written(force)?, dfdx: matrix(dfdx)?, dfdv: matrix(dfdv)? })
    }
}

fn evaluate<N: Number>(
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
