//! The order of the factors of a product, so that it stays in the range of floats on the way.
//!
//! In: a product or quotient and the valuation of its parts. Out: the same as it was, where no product of the first so
//! many factors is far smaller or larger than the whole where positions meet; else with factors that grow and such that
//! vanish in turns, and divided as often as that takes. 1e-28 · (1e21 · 1e21) is infinite in floats, (1e-28 · 1e21) · 1e21
//! is not.

use crate::scalar::valuation::Valuation;
use crate::schedule::Expression;

/// A product or quotient in an order that floats hold.
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
    match product.pop() {
        Some(quotient) if product.is_empty() => quotient,
        last => {
            product.extend(last);
            Expression::Quotient(product, Vec::new())
        }
    }
}

/// Whether what is reached factor by factor lies on the way to the whole.
fn are_on_the_way(factors: &[Valuation], whole: Valuation) -> bool {
    let mut reached = Valuation::ZERO;
    factors.iter().all(|factor| {
        reached = reached + *factor;
        reached.is_on_the_way_to(whole)
    })
}

impl Expression {
    /// How it vanishes or grows where positions meet, from the same of names and inputs.
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
