//! Division of every sum by existing sums, to write values in terms of other values.
//!
//! In and out: a [`Network`]. Weak division, as in logic synthesis: p = q d + r with d an existing sum; q and
//! r are found by matching terms. The result is kept if p becomes shorter.

use crate::math::exact::Exact;
use crate::optimize::extract::term_cost;
use crate::optimize::network::{Network, Value};
use crate::optimize::polynomial::{Atom, Monomials, Polynomial};
use rustc_hash::FxHashMap;

/// The longest sum that is used as a divisor.
const WIDE: usize = 8;

/// Rewrites sums in terms of existing sums; returns whether anything changed.
pub fn resubstitute(network: &mut Network) -> bool {
    let order = network.order();
    let mut frequency: FxHashMap<Atom, usize> = FxHashMap::default();
    for &atom in &order {
        if let Value::Sum(_) = network.values[atom as usize] {
            network.each_operand(atom, |operand| *frequency.entry(operand).or_default() += 1);
        }
    }
    // Divisors by their rarest atom, which every dividend must contain.
    let mut divisors: FxHashMap<Atom, Vec<Atom>> = FxHashMap::default();
    let mut changed = false;
    let mut candidates: Vec<Atom> = Vec::new();
    for &atom in &order {
        let Value::Sum(polynomial) = &mut network.values[atom as usize] else { continue };
        let mut polynomial = std::mem::take(polynomial);
        if polynomial.len() >= 2 {
            candidates.clear();
            for monomial in polynomial.monomials() {
                let atoms = network.monomials.atoms(monomial);
                candidates.extend(atoms.iter().flat_map(|a| divisors.get(a).into_iter().flatten()));
            }
            candidates.sort_unstable();
            candidates.dedup();
            for &divisor in &candidates {
                let Value::Sum(by) = &network.values[divisor as usize] else { continue };
                if let Some(shorter) = divide(&mut network.monomials, &polynomial, by, divisor) {
                    polynomial = shorter;
                    changed = true;
                }
            }
        }
        if (2..=WIDE).contains(&polynomial.len()) {
            let atoms = polynomial.monomials().flat_map(|m| network.monomials.atoms(m));
            if let Some(rarest) = atoms.min_by_key(|a| (frequency.get(a), **a)) {
                divisors.entry(*rarest).or_default().push(atom);
            }
        }
        network.values[atom as usize] = Value::Sum(polynomial);
    }
    if changed {
        network.sweep();
    }
    changed
}

/// p as quotient · divisor + rest, if that is shorter.
fn divide(monomials: &mut Monomials, p: &Polynomial, by: &Polynomial, divisor: Atom) -> Option<Polynomial> {
    if by.len() > p.len() {
        return None;
    }
    let mut quotient: Option<Vec<(Vec<Atom>, Exact)>> = None;
    for (m, c) in by.terms() {
        let mut found = Vec::new();
        for (n, d) in p.terms() {
            if let Some(rest) = monomials.quotient(monomials.atoms(*n), monomials.atoms(*m)) {
                let value = if c.is_one() { d.clone() } else { d * &c.recip() };
                let term = (rest, value);
                if quotient.as_ref().is_none_or(|q| q.contains(&term)) {
                    found.push(term);
                }
            }
        }
        if found.is_empty() {
            return None;
        }
        quotient = Some(found);
    }
    let mut quotient = quotient?;
    quotient.sort();
    let mut rest = p.clone();
    for (atoms, q) in &quotient {
        for (m, c) in by.terms() {
            let mut product = atoms.clone();
            product.extend_from_slice(monomials.atoms(*m));
            let monomial = monomials.intern(&mut product);
            rest.add(monomial, &-(q * c));
        }
    }
    for (mut atoms, q) in quotient {
        atoms.push(divisor);
        let monomial = monomials.intern(&mut atoms);
        rest.add(monomial, &q);
    }
    (cost(monomials, &rest) < cost(monomials, p)).then_some(rest)
}

fn cost(monomials: &Monomials, polynomial: &Polynomial) -> i64 {
    let terms = polynomial.terms().iter();
    polynomial.len() as i64 + terms.map(|(m, c)| term_cost(monomials.degree(*m), c)).sum::<i64>()
}
