//! Constructors of expressions that keep signs few.
//!
//! In: expressions. Out: an expression of the same value in which minus signs are merged into sums,
//! differences and numbers where that costs no operation, and quotients of quotients are one quotient.

use crate::math::exact::Exact;
use crate::schedule::Expression;

/// −x, with an existing sign flipped where possible.
pub(super) fn negate(value: Expression) -> Expression {
    match free_negative(&value) {
        Some(negative) => negative,
        None => Expression::Negative(Box::new(value)),
    }
}

/// −x, if the negation costs no operation.
fn free_negative(value: &Expression) -> Option<Expression> {
    match value {
        Expression::Literal(number) => Some(Expression::Literal(-number)),
        Expression::Negative(x) => Some((**x).clone()),
        Expression::Difference(pair) => {
            let [first, second] = &**pair;
            Some(Expression::Difference(Box::new([second.clone(), first.clone()])))
        }
        Expression::Sum(terms) => {
            let turned: Vec<_> = terms.iter().map(|(negative, x)| (!negative, x.clone())).collect();
            match sum(turned) {
                Expression::Sum(terms) if terms[0].0 => None,
                sum => Some(sum),
            }
        }
        Expression::Quotient(over, under) => {
            let (index, factor) =
                over.iter().enumerate().find_map(|(i, factor)| free_negative(factor).map(|f| (i, f)))?;
            let mut over = over.clone();
            over[index] = factor;
            Some(Expression::Quotient(over, under.clone()))
        }
        _ => None,
    }
}

/// The sides of a comparison with as few signs as possible: −x < −y becomes y < x, −x < 0 becomes 0 < x.
pub(super) fn turned(x: Expression, y: Expression) -> [Expression; 2] {
    let sign = |side: &Expression| match side {
        Expression::Negative(_) => -1,
        Expression::Literal(value) if value.is_zero() => 0,
        Expression::Literal(value) if value.is_negative() => -1,
        _ => 1,
    };
    if sign(&x) + sign(&y) < 0 { [negate(y), negate(x)] } else { [x, y] }
}

/// A sum whose first term is positive if any term is.
pub(super) fn sum(mut terms: Vec<(bool, Expression)>) -> Expression {
    for (negative, term) in &mut terms {
        if let Expression::Negative(x) = term {
            *term = std::mem::replace(x, Expression::Known(false));
            *negative = !*negative;
        }
    }
    if terms[0].0 {
        if let Some(positive) = terms.iter().position(|(negative, _)| !negative) {
            terms[..=positive].rotate_right(1);
        } else if let Some((index, turned)) =
            terms.iter().enumerate().find_map(|(i, (_, x))| free_negative(x).map(|x| (i, x)))
        {
            terms[..=index].rotate_right(1);
            terms[0] = (false, turned);
        }
    }
    Expression::Sum(terms)
}

/// A quotient into which factors that are products or quotients are merged; its numeric factors become one
/// leading number.
pub(super) fn quotient(over: Vec<Expression>, under: Vec<Expression>) -> Expression {
    let mut number = Exact::ONE;
    let mut negative = false;
    let (mut factors, mut divisors) = (Vec::new(), Vec::new());
    let mut unsigned = |factor: Expression| match factor {
        Expression::Negative(x) => {
            negative = !negative;
            *x
        }
        factor => factor,
    };
    for factor in over {
        match unsigned(factor) {
            Expression::Quotient(over, under) => {
                factors.extend(over);
                divisors.extend(under);
            }
            factor => factors.push(factor),
        }
    }
    for divisor in under {
        match unsigned(divisor) {
            Expression::Quotient(over, under) if under.is_empty() => divisors.extend(over),
            divisor => divisors.push(divisor),
        }
    }
    factors.retain(|factor| match factor {
        Expression::Literal(value) => {
            number = &number * value;
            false
        }
        _ => true,
    });
    if !number.is_one() {
        factors.insert(0, Expression::Literal(number));
    }
    let value = if factors.len() == 1 && divisors.is_empty() {
        factors.remove(0)
    } else {
        Expression::Quotient(factors, divisors)
    };
    if negative { negate(value) } else { value }
}
