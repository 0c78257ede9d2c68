//! Factors outside the range of a precision, in products whose value is in the range.
//!
//! In: statements and a precision. Out: the same statements, in which a factor such as 1e-60 is, for floats,
//! split into two numbers with other factors between them; or an error with the first out-of-range number
//! that is not a factor of a product. Promise: no partial product leaves the range unless the product does.

use crate::math::exact::Exact;
use crate::math::number::Precision;
use crate::schedule::{Expression, Schedule, Statement};

impl Schedule {
    /// Splits the factors that are out of range; returns the first number that is out of range and cannot be
    /// split.
    pub fn fit(&mut self, precision: Precision) -> Result<(), Exact> {
        for statement in &mut self.statements {
            let expressions = match statement {
                Statement::Let(_, value)
                | Statement::Store(_, value)
                | Statement::Add(_, _, value)
                | Statement::Leave(value) => std::slice::from_mut(value),
                Statement::Scaled { factor, .. } => std::slice::from_mut(factor),
                Statement::Columns(_, values) => values.as_mut_slice(),
                Statement::Zero { .. } | Statement::Negated { .. } | Statement::Heading(..) => &mut [],
            };
            for expression in expressions {
                fit(expression, precision)?;
            }
        }
        Ok(())
    }
}

/// Splits the out-of-range factors of an expression.
fn fit(expression: &mut Expression, precision: Precision) -> Result<(), Exact> {
    match expression {
        Expression::Literal(value) if !value.fits(precision) => return Err(value.clone()),
        Expression::Literal(_) | Expression::Known(_) | Expression::Input(_) | Expression::Name(_) => {}
        Expression::Negative(x) | Expression::Not(x) => fit(x, precision)?,
        Expression::Sum(terms) => terms.iter_mut().try_for_each(|(_, x)| fit(x, precision))?,
        Expression::Call(_, arguments) => arguments.iter_mut().try_for_each(|x| fit(x, precision))?,
        Expression::Select(parts) => parts.iter_mut().try_for_each(|x| fit(x, precision))?,
        Expression::Fused(parts) => {
            let misfit = |x: &Expression| matches!(x, Expression::Literal(value) if !value.fits(precision));
            let [x, y, _] = &mut **parts;
            if misfit(y) {
                std::mem::swap(x, y);
            }
            if let Expression::Literal(value) = x
                && !value.fits(precision)
                && !matches!(y, Expression::Literal(_))
            {
                // One part of the number remains as a factor of the fused multiply-add.
                let mut numbers = parts_of(value, precision);
                let last = numbers.pop().expect("a number that does not fit has parts");
                let other = std::mem::replace(y, last);
                *x = interleaved(numbers, vec![other]);
            }
            parts.iter_mut().try_for_each(|x| fit(x, precision))?;
        }
        Expression::Difference(pair)
        | Expression::Compare(_, pair)
        | Expression::And(pair)
        | Expression::Or(pair) => pair.iter_mut().try_for_each(|x| fit(x, precision))?,
        Expression::Quotient(over, under) => {
            let (mut above, mut below) = (Vec::new(), Vec::new());
            for (factors, numbers) in [(&mut *over, &mut above), (&mut *under, &mut below)] {
                factors.retain(|factor| match factor {
                    Expression::Literal(value) if !value.fits(precision) => {
                        numbers.push(value.clone());
                        false
                    }
                    _ => true,
                });
                factors.iter_mut().try_for_each(|x| fit(x, precision))?;
            }
            let Some(first) = above.first().or(below.first()).cloned() else { return Ok(()) };
            let is_number = |factor: &Expression| matches!(factor, Expression::Literal(_));
            if over.iter().chain(&*under).all(is_number) {
                return Err(first);
            }
            let mut above: Vec<Expression> = above.iter().flat_map(|x| parts_of(x, precision)).collect();
            let below: Vec<Expression> = below.iter().flat_map(|x| parts_of(x, precision)).collect();
            // The numerator takes as many numbers as it has other factors; the remaining numbers multiply the
            // quotient.
            let rest = match under.is_empty() {
                true => Vec::new(),
                false => above.split_off(above.len().min(over.len().max(1))),
            };
            let mut value = interleaved(above, std::mem::take(over));
            if !under.is_empty() {
                value = Expression::Quotient(vec![value], std::mem::take(under));
            }
            if !rest.is_empty() {
                value = interleaved(vec![value], rest);
            }
            for number in below {
                value = Expression::Quotient(vec![value], vec![number]);
            }
            *expression = value;
        }
    }
    Ok(())
}

/// A product of numbers and other factors, alternating.
fn interleaved(numbers: Vec<Expression>, factors: Vec<Expression>) -> Expression {
    let mut product = Vec::with_capacity(numbers.len() + factors.len());
    let (mut numbers, mut factors) = (numbers.into_iter(), factors.into_iter());
    loop {
        let before = product.len();
        product.extend(numbers.next());
        product.extend(factors.next());
        if product.len() == before {
            return Expression::Quotient(product, Vec::new());
        }
    }
}

/// A number as a product of in-range numbers: all but the first are powers of two.
fn parts_of(number: &Exact, precision: Precision) -> Vec<Expression> {
    // A factor between two of the parts may be as large, or as small.
    let most = match precision {
        Precision::F64 => 900,
        Precision::F32 => 100,
    };
    let exponent = number.exponent();
    let count = exponent.unsigned_abs().div_ceil(most).max(2);
    let power = Exact::from(2).powi((exponent / count as i64) as i32);
    let first = number * &power.powi(1 - count as i32);
    let powers = std::iter::repeat_n(power, count as usize - 1);
    std::iter::once(first).chain(powers).map(Expression::Literal).collect()
}
