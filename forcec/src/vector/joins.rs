//! Joins terms and factors that overflow or are singular separately but not together: exponentials, and
//! angles over sines.
//!
//! In: the terms of a sum, or the factors of a product. Out: the same value wherever the input is defined and
//! finite, and its limit elsewhere: 1/(1 + eᵘ) becomes logistic(−u), which is also valid where eᵘ is
//! infinite, and so are its derivatives.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::vector::{Graph, Node, Real};
use std::collections::BTreeMap;

/// Higher powers of a divisor are not joined.
const LARGEST_POWER: i64 = 64;

/// Factors and their exponents.
type Powers = BTreeMap<Real, i64>;

impl Graph {
    /// The node of a real, with lets expanded.
    fn opened(&self, mut real: Real) -> &Node {
        while let Node::Let(inner) = self.at(real) {
            real = *inner;
        }
        self.at(real)
    }

    /// The exponent u of eᵘ.
    pub(crate) fn exponent(&self, real: Real) -> Option<Real> {
        match self.opened(real) {
            Node::Call(Function::Exp, arguments) => Some(arguments[0]),
            _ => None,
        }
    }

    /// (a, b, u) of a + b eᵘ with a and b ±1; eᵘ − 1 is also recognised as a function of its own.
    pub(crate) fn one_and_exponential(&self, real: Real) -> Option<(bool, bool, Real)> {
        match self.opened(real) {
            Node::Sum(constant, terms) if constant.is_unit() => match &**terms {
                [(c, term)] if c.is_unit() => {
                    Some((!constant.is_negative(), !c.is_negative(), self.exponent(*term)?))
                }
                _ => None,
            },
            Node::Call(Function::ExpM1, arguments) => Some((false, true, arguments[0])),
            _ => None,
        }
    }

    /// Joins pairs of terms: eᵘ + e⁻ᵘ is 2 cosh u, eᵘ − e⁻ᵘ is 2 sinh u, 1 − logistic u is logistic(−u).
    pub(super) fn pair_exponentials(
        &mut self,
        constant: &mut Exact,
        mut terms: Vec<(Exact, Real)>,
    ) -> Vec<(Exact, Real)> {
        let exponentials: BTreeMap<Real, usize> = terms
            .iter()
            .enumerate()
            .filter_map(|(at, (_, term))| Some((self.exponent(*term)?, at)))
            .collect();
        let mut changed = false;
        for (&u, &at) in exponentials.iter().filter(|_| exponentials.len() > 1) {
            let opposite = self.neg(u);
            let Some(&other) = exponentials.get(&opposite).filter(|other| **other > at) else { continue };
            let (c, d) = (terms[at].0.clone(), terms[other].0.clone());
            let function = match c == d {
                true => Function::Cosh,
                false if c == -&d => Function::Sinh,
                false => continue,
            };
            let joined = self.call(function, &[u]);
            terms[at] = (&Exact::from(2) * &c, joined);
            terms[other].0 = Exact::ZERO;
            changed = true;
        }
        let logistic = terms.iter().position(|(c, term)| {
            *c == -&*constant && matches!(self.opened(*term), Node::Call(Function::Logistic, _))
        });
        if let Some(at) = logistic.filter(|_| !constant.is_zero())
            && let Node::Call(_, arguments) = self.opened(terms[at].1)
        {
            let u = arguments[0];
            let opposite = self.neg(u);
            let joined = self.call(Function::Logistic, &[opposite]);
            terms[at] = (std::mem::replace(constant, Exact::ZERO), joined);
            changed = true;
        }
        if !changed {
            return terms;
        }
        // A sine of a negative argument becomes a term with a coefficient.
        let split = terms.into_iter().map(|(c, term)| {
            let (own, rest) = self.split(term);
            (&c * &own, rest)
        });
        crate::math::exact::collect(split.collect())
    }

    /// Joins quotients: 1/(1 + eᵘ) is logistic(−u), eᵘ/(1 + eᵘ) is logistic u, (eᵘ − 1)/(1 + eᵘ) is
    /// tanh(u/2), eᵘ/(eᵘ − 1)² is 1/(4 sinh²(u/2)), eᵘ/(eᵘ − 1) is −1/(e⁻ᵘ − 1). Returns the resulting
    /// coefficient.
    pub(super) fn join_exponentials(&mut self, powers: &mut Powers) -> Exact {
        let mut coefficient = Exact::ONE;
        let divisors: Vec<(Real, i64, (bool, bool, Real))> = powers
            .iter()
            .filter(|(_, e)| (-LARGEST_POWER..0).contains(*e))
            .filter_map(|(f, e)| Some((*f, -e, self.one_and_exponential(*f)?)))
            .collect();
        for (divisor, count, (constant, exponential, u)) in divisors {
            let over: Vec<(Real, i64)> = powers
                .iter()
                .filter(|(f, e)| **e > 0 && self.exponent(**f) == Some(u))
                .map(|(f, e)| (*f, *e))
                .collect();
            let mut rest = count;
            let half = |g: &mut Graph| g.scaled(Exact::ratio(1, 2), u);
            if constant != exponential {
                // ±(eᵘ − 1)
                for (exp, most) in over {
                    let pairs = most.min(rest / 2);
                    if pairs > 0 {
                        let half = half(self);
                        let sine = self.call(Function::Sinh, &[half]);
                        let (_, sine) = self.split(sine);
                        *powers.entry(sine).or_default() -= 2 * pairs;
                        coefficient = &coefficient * &Exact::ratio(1, 4).powi(pairs as i32);
                    }
                    let single = (most - pairs).min(rest - 2 * pairs);
                    if single > 0 {
                        let opposite = self.neg(u);
                        let below = self.call(Function::ExpM1, &[opposite]);
                        *powers.entry(below).or_default() -= single;
                        if exponential && single % 2 == 1 {
                            coefficient = -coefficient;
                        }
                    }
                    *powers.entry(exp).or_default() -= pairs + single;
                    rest -= 2 * pairs + single;
                }
                *powers.entry(divisor).or_default() += count - rest;
                continue;
            }
            if !constant {
                // −1 − eᵘ
                continue;
            }
            let differences: Vec<(Real, i64, bool)> = powers
                .iter()
                .filter(|(_, e)| **e > 0)
                .filter_map(|(f, e)| match self.one_and_exponential(*f)? {
                    (constant, exponential, v) if constant != exponential && u == v => {
                        Some((*f, *e, exponential))
                    }
                    _ => None,
                })
                .collect();
            for (difference, most, positive) in differences {
                let joined = most.min(rest);
                let half = half(self);
                let tangent = self.call(Function::Tanh, &[half]);
                let (sign, tangent) = self.split(tangent);
                for (factor, change) in [(difference, -joined), (tangent, joined)] {
                    *powers.entry(factor).or_default() += change;
                }
                if joined % 2 == 1 && positive == sign.is_negative() {
                    coefficient = -coefficient;
                }
                rest -= joined;
            }
            let mut above = 0;
            for (exp, most) in over {
                let joined = most.min(rest - above);
                *powers.entry(exp).or_default() -= joined;
                above += joined;
            }
            let below = rest - above;
            let both = above.min(below);
            let opposite = self.neg(u);
            for (function, argument, exponent) in [
                (Function::LogisticSlope, u, both),
                (Function::Logistic, u, above - both),
                (Function::Logistic, opposite, below - both),
            ] {
                if exponent > 0 {
                    let value = self.call(function, &[argument]);
                    match self.value(value).cloned() {
                        Some(value) => coefficient = &coefficient * &value.powi(exponent as i32),
                        None => *powers.entry(value).or_default() += exponent,
                    }
                }
            }
            *powers.entry(divisor).or_default() += count;
        }
        coefficient
    }

    /// θ/|v| with θ = atan2(|v|, w) is a function of the table, smooth at v = 0 for w > 0, and θ |v| is |v|²
    /// times this function: the square of an angle has derivatives where the angle itself has a kink.
    pub(super) fn join_angles(&mut self, powers: &mut Powers) {
        let angles: Vec<(Real, i64, Real, Real)> = powers
            .iter()
            .filter(|(_, e)| **e > 0)
            .filter_map(|(f, e)| match self.opened(*f) {
                Node::Call(Function::Atan2, arguments) => Some((*f, *e, arguments[0], arguments[1])),
                _ => None,
            })
            .collect();
        for (angle, most, sine, cosine) in angles {
            let Node::Norm(v) = *self.opened(sine) else { continue };
            let norm = powers.iter().find(|(f, e)| **e != 0 && *self.opened(**f) == Node::Norm(v));
            let Some((norm, exponent)) = norm.map(|(f, e)| (*f, *e)) else { continue };
            let joined = if exponent < 0 { most.min(-exponent) } else { exponent % 2 };
            if joined == 0 {
                continue;
            }
            let square = self.dot(v, v);
            let ratio = self.call(Function::AngleRatio(0), &[square, cosine]);
            for (factor, change) in [(angle, -joined), (norm, joined), (ratio, joined)] {
                *powers.entry(factor).or_default() += change;
            }
        }
    }
}
