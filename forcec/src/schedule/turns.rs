//! Orders the factors of a product so that partial products stay in the range of floats.
//!
//! In: a product or quotient and the valuations of its factors. Out: the same expression unchanged, if no
//! partial product is far smaller or larger than the whole as positions coincide; otherwise the product with
//! growing and vanishing factors alternating, and with as many divisions as that order needs. 1e-28 · (1e21 ·
//! 1e21) is infinite in floats, (1e-28 · 1e21) · 1e21 is not.

use crate::scalar::valuation::Valuation;
use crate::schedule::Expression;

/// A product or quotient in an order whose partial products are in the range of floats.
pub(super) fn in_turns(
    over: Vec<Expression>,
    under: Vec<Expression>,
    of: &impl Fn(&Expression) -> Valuation,
) -> Expression {
    let factors: Vec<Valuation> = over.iter().map(of).collect();
    let divisors: Vec<Valuation> = under.iter().map(of).collect();
    let divisor: Valuation = divisors.iter().copied().sum();
    let whole = factors.iter().copied().sum::<Valuation>() + -divisor;
    let divides = under.len() < 2 || are_on_the_way(&divisors, Valuation::ZERO);
    if are_on_the_way(&factors, whole) && divides {
        return Expression::Quotient(over, under);
    }
    let mut rest: Vec<(bool, Valuation, Expression)> = Vec::with_capacity(over.len() + under.len());
    rest.extend(over.into_iter().zip(factors).map(|(x, valuation)| (false, valuation, x)));
    rest.extend(under.into_iter().zip(divisors).map(|(x, valuation)| (true, -valuation, x)));
    let (mut product, mut reached) = (Vec::new(), Valuation::ZERO);
    while !rest.is_empty() {
        let begun = !product.is_empty();
        let next = (0..rest.len())
            .filter(|place| begun || !rest[*place].0)
            .min_by_key(|place| ((reached + rest[*place].1).size(), rest[*place].0))
            .unwrap_or(0);
        let (divides, valuation, factor) = rest.remove(next);
        reached = reached + valuation;
        if divides {
            product = vec![Expression::Quotient(product, vec![factor])];
        } else {
            product.push(factor);
        }
    }
    match product.len() {
        1 => product.remove(0),
        _ => Expression::Quotient(product, Vec::new()),
    }
}

/// Whether every partial product lies between one and the whole.
fn are_on_the_way(factors: &[Valuation], whole: Valuation) -> bool {
    let mut reached = Valuation::ZERO;
    factors.iter().all(|factor| {
        reached = reached + *factor;
        reached.is_on_the_way_to(whole)
    })
}

impl Expression {
    /// The valuation of an expression, from the valuations of names and inputs: how it vanishes or grows as
    /// positions coincide.
    pub(super) fn valuation(&self, of: &impl Fn(&Expression) -> Valuation) -> Valuation {
        let all = |parts: &[Expression]| parts.iter().map(|x| x.valuation(of)).collect::<Vec<_>>();
        match self {
            Expression::Input(_) | Expression::Name(_) => of(self),
            Expression::Negative(x) => x.valuation(of),
            Expression::Difference(pair) => pair[0].valuation(of).max(pair[1].valuation(of)),
            Expression::Sum(terms) => Valuation::least(terms.iter().map(|(_, x)| x.valuation(of))),
            Expression::Quotient(over, under) => {
                all(over).into_iter().chain(all(under).into_iter().map(|x| -x)).sum()
            }
            Expression::Fused(parts) => {
                let [x, y, z] = parts.each_ref().map(|x| x.valuation(of));
                (x + y).min(z)
            }
            Expression::Call(function, arguments) => Valuation::of_call(*function, &all(arguments)),
            Expression::Select(parts) => parts[1].valuation(of).min(parts[2].valuation(of)),
            _ => Valuation::ZERO,
        }
    }
}
