//! Local search around the greedy factoring: each round dissolves some values into their users, factors the
//! network again, and keeps the result if it does not cost more.
//!
//! In and out: a [`Network`]. The random numbers have a fixed seed and rounds are counted, so the output is
//! deterministic. Never dissolved: named values, except in a free search, and sums that can be exact when
//! small, because their users would lose accuracy. A product of two sums is not expanded. Dissolving other
//! values changes the error by a small factor only.

use crate::math::random::Random;
use crate::optimize::extract::extract;
use crate::optimize::network::{Network, Value};
use crate::optimize::polynomial::{Atom, Monomial};
use crate::optimize::resubstitute::resubstitute;
use rustc_hash::FxHashSet;

/// One round: the share of values to try, `1/2^rarity`, and the longest sum that may result.
struct Round {
    rarity: u32,
    longest: usize,
}

/// The rounds, repeated cyclically.
const ROUNDS: [Round; 8] = [
    Round { rarity: 0, longest: 6 },
    Round { rarity: 1, longest: 6 },
    Round { rarity: 0, longest: 8 },
    Round { rarity: 1, longest: 6 },
    Round { rarity: 2, longest: 6 },
    Round { rarity: 0, longest: 4 },
    Round { rarity: 1, longest: 12 },
    Round { rarity: 3, longest: 6 },
];

/// Searches for `rounds` rounds, or until `patience` rounds in a row bring no improvement. `steps` limits
/// each factoring. `free` allows named values to be dissolved.
pub fn search(network: &mut Network, rounds: usize, patience: usize, steps: usize, free: bool) {
    let mut random = Random::new(0x9E37_79B9_7F4A_7C15);
    let mut idle = 0;
    let mut cost = network.operations().total();
    let mut candidates = dissolvable(network, free);
    for round in ROUNDS.iter().cycle().take(rounds) {
        if candidates.is_empty() || idle == patience {
            return;
        }
        let mut attempt = network.clone();
        let mut users = network.users();
        let small: FxHashSet<Atom> = candidates.iter().copied().filter(|x| network.is_mixed(*x)).collect();
        for _ in 0..=candidates.len() >> round.rarity {
            let atom = candidates[random.below(candidates.len())];
            dissolve(&mut attempt, &mut users, &small, atom, round.longest);
        }
        extract(&mut attempt, steps);
        if resubstitute(&mut attempt) {
            extract(&mut attempt, steps);
        }
        let total = attempt.operations().total();
        idle = if total < cost { 0 } else { idle + 1 };
        if total <= cost {
            cost = total;
            *network = attempt;
            candidates = dissolvable(network, free);
        }
    }
}

/// The sums that may be dissolved: unnamed unless the search is free, never exact, and read by sums only.
fn dissolvable(network: &Network, free: bool) -> Vec<Atom> {
    let order = network.order();
    let mut stays = exact(network, &order);
    for root in network.roots() {
        stays[root as usize] = true;
    }
    for &atom in &order {
        if let Value::Operation(_, operands) = &network.values[atom as usize] {
            operands.iter().for_each(|x| stays[*x as usize] = true);
        }
    }
    let is_sum = |atom: &Atom| matches!(network.values[*atom as usize], Value::Sum(_));
    order
        .into_iter()
        .filter(|x| is_sum(x) && !stays[*x as usize] && (free || !network.is_named(*x)))
        .collect()
}

/// The atoms whose relative error can be far below that of their operands: inputs, pinned differences,
/// numbers, and sums in which two exact terms can cancel.
fn exact(network: &Network, order: &[Atom]) -> Vec<bool> {
    let mut exact = vec![false; network.values.len()];
    for &atom in order {
        exact[atom as usize] = match &network.values[atom as usize] {
            Value::Leaf(_) | Value::Number(_) => true,
            Value::Sum(polynomial) => {
                let plain = |m: &Monomial| match network.monomials.atoms(*m) {
                    [] => true,
                    [atom] => exact[*atom as usize],
                    _ => false,
                };
                polynomial.monomials().filter(plain).count() >= 2
            }
            Value::Operation(..) | Value::Dead => false,
        };
    }
    exact
}

/// Multiplies a sum out in all its users, if these stay at most `longest` terms long.
///
/// A product of two sums in `small` is not expanded: if both are small, their terms need not be.
fn dissolve(
    network: &mut Network,
    users: &mut [Vec<Atom>],
    small: &FxHashSet<Atom>,
    atom: Atom,
    longest: usize,
) {
    let Value::Sum(definition) = &network.values[atom as usize] else { return };
    let definition = definition.clone();
    let mut changed = Vec::new();
    let mut readers = users[atom as usize].clone();
    readers.dedup();
    for user in readers {
        let Value::Sum(polynomial) = &network.values[user as usize] else { continue };
        let mut polynomial = polynomial.clone();
        let monomials = &mut network.monomials;
        while let Some((monomial, coefficient)) =
            polynomial.take_first(|m| monomials.atoms(m).contains(&atom))
        {
            let rest = monomials.quotient(monomials.atoms(monomial), &[atom]).expect("it is held");
            if rest.iter().any(|x| small.contains(x)) {
                return;
            }
            for (term, c) in definition.terms() {
                let mut product = rest.clone();
                product.extend_from_slice(monomials.atoms(*term));
                polynomial.add(monomials.intern(&mut product), &(&coefficient * c));
            }
            if polynomial.len() > longest {
                return;
            }
        }
        changed.push((user, polynomial));
    }
    for (user, polynomial) in changed {
        network.values[user as usize] = Value::Sum(polynomial);
        network.each_operand(atom, |x| users[x as usize].push(user));
    }
    network.values[atom as usize] = Value::Dead;
}
