//! Division of every sum by the sums that exist already: where a value can be written with another one, it is.
//!
//! In and out: a [`Network`]. Weak division, as in logic synthesis: p = q d + r with d an existing sum, q and r found by
//! matching terms; kept where p gets shorter.

use super::extract::term_cost;
use super::network::{Atom, Monomial, Network, Polynomial, Value, add_term};
use crate::exact::Exact;
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

/// Sums of more terms are no divisors.
const WIDE: usize = 8;

/// Rewrites sums with existing ones; whether anything changed.
pub fn resubstitute(network: &mut Network) -> bool {
    let order = network.order();
    let mut frequency: FxHashMap<Atom, usize> = FxHashMap::default();
    for &atom in &order {
        if let Value::Sum(_) = network.values[atom as usize] {
            for operand in network.operands(atom) {
                *frequency.entry(operand).or_default() += 1;
            }
        }
    }
    // Divisors by their rarest atom: what they divide must hold it.
    let mut divisors: FxHashMap<Atom, Vec<Atom>> = FxHashMap::default();
    let mut changed = false;
    for &atom in &order {
        let Value::Sum(polynomial) = &network.values[atom as usize] else { continue };
        let mut polynomial = polynomial.clone();
        if polynomial.len() >= 2 {
            let atoms: BTreeSet<Atom> =
                polynomial.keys().flat_map(|m| network.monomials.atoms(*m).iter().copied()).collect();
            let candidates: BTreeSet<Atom> =
                atoms.iter().flat_map(|a| divisors.get(a).into_iter().flatten()).copied().collect();
            for divisor in candidates {
                let Value::Sum(by) = &network.values[divisor as usize] else { continue };
                let by = by.clone();
                if let Some(shorter) = divide(network, &polynomial, &by, divisor) {
                    polynomial = shorter;
                    changed = true;
                }
            }
        }
        if (2..=WIDE).contains(&polynomial.len()) {
            let atoms = polynomial.keys().flat_map(|m| network.monomials.atoms(*m));
            if let Some(rarest) = atoms.min_by_key(|a| (frequency.get(a), **a)) {
                divisors.entry(*rarest).or_default().push(atom);
            }
        }
        network.values[atom as usize] = Value::Sum(polynomial);
    }
    network.sweep();
    changed
}

/// p written as quotient · divisor + rest, if that is shorter.
fn divide(network: &mut Network, p: &Polynomial, by: &Polynomial, divisor: Atom) -> Option<Polynomial> {
    if by.len() > p.len() {
        return None;
    }
    let mut quotient: Option<BTreeMap<Vec<Atom>, Exact>> = None;
    for (m, c) in by {
        let mut candidates = BTreeMap::new();
        for (n, d) in p {
            let rest = network.monomials.quotient(network.monomials.atoms(*n), network.monomials.atoms(*m));
            if let Some(rest) = rest {
                let value = if c.is_one() { d.clone() } else { d * &c.recip() };
                let agrees = quotient.as_ref().is_none_or(|q| q.get(&rest) == Some(&value));
                if agrees {
                    candidates.insert(rest, value);
                }
            }
        }
        if candidates.is_empty() {
            return None;
        }
        quotient = Some(candidates);
    }
    let quotient = quotient?;
    let mut rest = p.clone();
    for (atoms, q) in &quotient {
        for (m, c) in by {
            let mut product = atoms.clone();
            product.extend_from_slice(network.monomials.atoms(*m));
            let monomial = network.monomials.intern(product);
            add_term(&mut rest, monomial, &-(q * c));
        }
    }
    for (mut atoms, q) in quotient {
        atoms.push(divisor);
        let monomial = network.monomials.intern(atoms);
        add_term(&mut rest, monomial, &q);
    }
    (cost(network, &rest) < cost(network, p)).then_some(rest)
}

fn cost(network: &Network, polynomial: &Polynomial) -> i64 {
    let degree = |m: &Monomial| network.monomials.degree(*m);
    polynomial.len() as i64 + polynomial.iter().map(|(m, c)| term_cost(degree(m), c)).sum::<i64>()
}
