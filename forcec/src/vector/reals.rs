//! Reals: sums with like terms collected, products with powers merged, functions, selections.
//!
//! In: operands. Out: the canonical node of an operation on them; in a verbatim graph, the operation as
//! written. Promise: the value does not change wherever it was defined and finite; accumulating n terms or
//! factors stays linear in n.

use crate::math::exact::{Exact, collect};
use crate::math::functions::Function;
use crate::model::bodies::Slot;
use crate::vector::{Graph, LONGEST_SUM, Node, Real, Truth, identities};
use std::collections::BTreeMap;

/// Longer products are not merged into other products but become one factor: the derivative of a chain stays
/// linear.
const LONGEST_PRODUCT: usize = 8;

impl Graph {
    /// A number.
    pub fn constant(&mut self, value: Exact) -> Real {
        self.real(Node::Constant(value))
    }

    /// 0
    pub fn zero(&mut self) -> Real {
        self.constant(Exact::ZERO)
    }

    /// 1
    pub fn one(&mut self) -> Real {
        self.constant(Exact::ONE)
    }

    /// The value of a node that is a number.
    pub fn value(&self, real: Real) -> Option<&Exact> {
        match self.at(real) {
            Node::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// Whether a node is the number 0.
    pub fn is_zero(&self, real: Real) -> bool {
        self.value(real).is_some_and(Exact::is_zero)
    }

    /// An argument entry, or the number that replaces the entry.
    pub fn entry(&mut self, slot: Slot) -> Real {
        if self.simplify
            && let Some(value) = self.signature.folded(slot)
        {
            return self.constant(value);
        }
        self.real(Node::Entry(slot))
    }

    /// Splits a node into coefficient and rest: −2x is (−2, x).
    pub fn split(&self, real: Real) -> (Exact, Real) {
        match self.at(real) {
            Node::Sum(constant, terms) if terms.len() == 1 && constant.is_zero() => terms[0].clone(),
            _ => (Exact::ONE, real),
        }
    }

    /// constant + Σ coefficient · term
    pub fn sum(&mut self, constant: Exact, terms: Vec<(Exact, Real)>) -> Real {
        if !self.simplify {
            return self.real(Node::Sum(constant, terms.into()));
        }
        let mut constant = constant;
        let mut flat: Vec<(Exact, Real)> = Vec::new();
        for (coefficient, term) in terms {
            match self.at(term) {
                Node::Constant(value) => constant = &constant + &(&coefficient * value),
                Node::Sum(inner, terms)
                    if terms.len() <= LONGEST_SUM && self.distributes(&coefficient, term) =>
                {
                    constant = &constant + &(&coefficient * inner);
                    flat.extend(terms.iter().map(|(c, t)| (&coefficient * c, *t)));
                }
                _ => flat.push((coefficient, term)),
            }
        }
        let flat = self.open_offsets(collect(flat), &mut constant);
        let flat = self.pair_exponentials(&mut constant, flat);
        let flat = self.balance_products(flat);
        let flat = self.pin_components(flat);
        match (constant.is_zero(), flat.as_slice()) {
            (_, []) => self.constant(constant),
            (true, [(c, term)]) if c.is_one() => *term,
            (false, [(c, term)]) if c.is_power_of_two() && self.is_entry(*term) => {
                let (c, offset) = (c.clone(), &constant * &c.recip());
                let pinned = self.real(Node::Offset(*term, offset));
                self.scaled(c, pinned)
            }
            _ => self.real(Node::Sum(constant, flat.into())),
        }
    }

    /// Whether distributing a coefficient over a sum causes no further rounding. A power of two is exact; any
    /// other coefficient rounds each term, and where the terms cancel, these rounding errors are all that
    /// remains. Sums with positions are distributed in any case, because positions are subtracted from each
    /// other first.
    fn distributes(&self, coefficient: &Exact, sum: Real) -> bool {
        let Node::Sum(constant, terms) = self.at(sum) else { return false };
        let is_multiple = terms.len() == 1 && constant.is_zero();
        is_multiple || coefficient.is_power_of_two() || constant.is_zero() && self.holds_point(sum)
    }

    /// x + y
    pub fn add(&mut self, x: Real, y: Real) -> Real {
        self.sum(Exact::ZERO, vec![(Exact::ONE, x), (Exact::ONE, y)])
    }

    /// x − y
    pub fn sub(&mut self, x: Real, y: Real) -> Real {
        self.sum(Exact::ZERO, vec![(Exact::ONE, x), (-Exact::ONE, y)])
    }

    /// −x
    pub fn neg(&mut self, x: Real) -> Real {
        self.scaled(-Exact::ONE, x)
    }

    /// coefficient · x
    pub fn scaled(&mut self, coefficient: Exact, x: Real) -> Real {
        self.sum(Exact::ZERO, vec![(coefficient, x)])
    }

    /// Π factor^exponent
    pub fn product(&mut self, factors: &[(Real, i32)]) -> Real {
        if !self.simplify {
            return self.real(Node::Product(factors.into()));
        }
        let mut coefficient = Exact::ONE;
        let mut powers: BTreeMap<Real, i64> = BTreeMap::new();
        let mut pending: Vec<(Real, i32)> = factors.iter().rev().copied().collect();
        while let Some((factor, exponent)) = pending.pop() {
            if exponent == 0 {
                continue;
            }
            let (c, rest) = self.split(factor);
            let c = self.value(rest).map_or(c.clone(), |value| &c * value);
            let raised = exponent.unsigned_abs() > 1 && self.value(rest).is_none();
            if c.is_zero() && exponent < 0 || raised && !c.power_stays(exponent.unsigned_abs()) {
                // IEEE arithmetic handles a division by a literal zero. A multiple whose coefficient would
                // leave the range is raised to the power as a whole.
                *powers.entry(factor).or_default() += i64::from(exponent);
                continue;
            }
            coefficient = &coefficient * &c.powi(exponent);
            match self.at(rest) {
                Node::Constant(_) => {}
                // (s/r)ⁿ is not expanded: sⁿ and r⁻ⁿ may leave the range where their quotient does not.
                Node::Product(inner) if inner.len() <= LONGEST_PRODUCT && exponent.abs() == 1 => {
                    let inner = inner.clone();
                    for (f, e) in inner {
                        *powers.entry(f).or_default() += i64::from(e) * i64::from(exponent);
                    }
                }
                _ => *powers.entry(rest).or_default() += i64::from(exponent),
            }
        }
        if coefficient.is_zero() {
            return self.zero();
        }
        self.join_bases(&mut powers, &mut coefficient);
        coefficient = &coefficient * &self.join_exponentials(&mut powers);
        self.join_hyperbolic(&mut powers);
        self.join_angles(&mut powers);
        let roots: Vec<Real> = powers.iter().filter(|(_, e)| e.abs() >= 2).map(|(f, _)| *f).collect();
        for root in roots {
            let radicand = match *self.rooted(root, powers[&root]) {
                Node::Call(Function::Sqrt, ref arguments) => arguments[0],
                Node::Norm(v) => self.dot(v, v),
                _ => continue,
            };
            let exponent = powers.remove(&root).expect("collected above");
            if exponent % 2 != 0 {
                powers.insert(root, exponent % 2);
            }
            let (c, rest) = self.split(radicand);
            if !c.is_one()
                || !matches!(self.at(rest), Node::Dot(..) | Node::Entry(_) | Node::Let(_) | Node::Call(..))
            {
                // Only an atom replaces its root; a product or sum would have to be expanded.
                *powers.entry(root).or_default() += exponent - exponent % 2;
                continue;
            }
            *powers.entry(rest).or_default() += exponent / 2;
        }
        powers.retain(|_, e| *e != 0);
        let factors: Vec<(Real, i32)> = powers
            .into_iter()
            .map(|(f, e)| (f, e.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32))
            .collect();
        let product = match factors.as_slice() {
            [] => return self.constant(coefficient),
            [(factor, 1)] => *factor,
            _ => self.real(Node::Product(factors.into())),
        };
        self.scaled(coefficient, product)
    }

    /// The node of a factor; for a let whose square is required, the bound node, so that |v|² is v·v through
    /// names too.
    fn rooted(&self, factor: Real, exponent: i64) -> &Node {
        match *self.at(factor) {
            Node::Let(inner) if exponent > 0 => self.at(inner),
            _ => self.at(factor),
        }
    }

    /// q⁵ s r⁻² = q⁶ r⁻¹ for a base q = s r⁻¹: differentiating a power of a product does not expand the
    /// product.
    fn join_bases(&self, powers: &mut BTreeMap<Real, i64>, coefficient: &mut Exact) {
        let bases: Vec<Real> = powers.iter().filter(|(_, e)| **e != 0).map(|(f, _)| *f).collect();
        for base in bases {
            let (c, rest) = self.split(base);
            let held = if let Node::Let(held) = *self.at(rest) { held } else { rest };
            let Node::Product(inner) = self.at(held) else { continue };
            let times = |(f, e): &(Real, i32)| {
                let held = powers.get(f).copied().unwrap_or(0);
                if (held > 0) == (*e > 0) { held / i64::from(*e) } else { 0 }
            };
            let count = inner.iter().map(times).min().unwrap_or(0);
            let joined = match i32::try_from(count) {
                Ok(size) if size > 0 => &*coefficient * &c.powi(-size),
                _ => continue,
            };
            if joined.is_beyond() {
                continue;
            }
            *coefficient = joined;
            for (f, e) in inner {
                *powers.get_mut(f).expect("counted above") -= count * i64::from(*e);
            }
            *powers.get_mut(&base).expect("a base is a factor") += count;
        }
    }

    /// sinh x / cosh x = tanh x: the terms in derivatives of tanh and of 1/sinh must not be ∞ · 0 for large
    /// x.
    pub(super) fn join_hyperbolic(&mut self, powers: &mut BTreeMap<Real, i64>) {
        let sines: Vec<(Real, i64)> = powers
            .iter()
            .filter(|(f, _)| matches!(self.at(**f), Node::Call(Function::Sinh, _)))
            .map(|(f, e)| (*f, *e))
            .collect();
        for (sine, count) in sines {
            let Node::Call(_, arguments) = self.at(sine).clone() else { continue };
            let cosine = self.real(Node::Call(Function::Cosh, arguments.clone()));
            let other = powers.get(&cosine).copied().unwrap_or(0);
            let joined = if (count > 0) == (other > 0) { 0 } else { count.abs().min(other.abs()) };
            let joined = joined * count.signum();
            if joined == 0 {
                continue;
            }
            let tangent = self.real(Node::Call(Function::Tanh, arguments));
            for (factor, change) in [(sine, -joined), (cosine, joined), (tangent, joined)] {
                *powers.entry(factor).or_default() += change;
            }
        }
    }

    /// x y
    pub fn mul(&mut self, x: Real, y: Real) -> Real {
        self.product(&[(x, 1), (y, 1)])
    }

    /// x / y
    pub fn div(&mut self, x: Real, y: Real) -> Real {
        self.product(&[(x, 1), (y, -1)])
    }

    /// xⁿ
    pub fn powi(&mut self, x: Real, n: i32) -> Real {
        self.product(&[(x, n)])
    }

    /// A function of the table.
    pub fn call(&mut self, function: Function, arguments: &[Real]) -> Real {
        if self.simplify
            && let Some(simpler) = identities::apply(self, function, arguments)
        {
            return simpler;
        }
        self.real(Node::Call(function, arguments.into()))
    }

    /// if the condition is true x, else y
    pub fn select(&mut self, condition: Truth, x: Real, y: Real) -> Real {
        if self.simplify {
            match *self.truth_at(condition) {
                Node::Known(known) => return if known { x } else { y },
                _ if x == y => return x,
                Node::Not(inner) => return self.select(inner, y, x),
                _ => {}
            }
        }
        self.real(Node::Select(condition, x, y))
    }
}
