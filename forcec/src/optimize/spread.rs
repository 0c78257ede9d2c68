//! Splits values that leave the range of floats where positions coincide, by moving factors into their users.
//!
//! In and out: a [`Network`]. With x and y columns of cofactors, λ/J² · x yᵀ has ordinary size but λ/J² has
//! not. Factors common to all terms of such a value move to its users, as many as necessary; factoring then
//! shares x/J instead. Named values are not split, nor are values whose users are as large or small.

use crate::optimize::network::{Network, Value};
use crate::optimize::polynomial::{Atom, Polynomial};
use crate::scalar::valuation::Valuation;

/// Splits values; returns whether any was split.
pub fn spread(network: &mut Network) -> bool {
    let mut valuations = network.valuations();
    let order = network.order();
    let beyond = |atom: &Atom| !valuations[*atom as usize].is_held();
    if !order.iter().any(beyond) {
        return false;
    }
    let mut changed = false;
    let mut users = network.users();
    let mut stays = vec![false; network.values.len()];
    network.roots().for_each(|root| stays[root as usize] = true);
    for &atom in order.iter().rev() {
        if stays[atom as usize] || network.is_named(atom) {
            continue;
        }
        if let Some(wanted) = wanted(network, &valuations, &users[atom as usize], atom) {
            changed |= take_apart(network, &mut valuations, &mut users, atom, wanted);
        }
    }
    if changed {
        network.sweep();
    }
    changed
}

/// The valuation nearest to 0 among a value's users, if the value is out of range and further from 0.
fn wanted(network: &Network, valuations: &[Valuation], users: &[Atom], atom: Atom) -> Option<Valuation> {
    let own = valuations[atom as usize];
    let of_atom = |atom: &Atom| valuations[*atom as usize];
    let mut nearest = own;
    for user in users {
        let Value::Sum(sum) = &network.values[*user as usize] else { return None };
        let products = sum.monomials().map(|monomial| network.monomials.atoms(monomial));
        for product in products.filter(|product| product.contains(&atom)) {
            nearest = [nearest, product.iter().map(of_atom).sum()].into_iter().min_by_key(|v| v.size())?;
        }
    }
    (!own.is_on_the_way_to(nearest)).then_some(nearest)
}

/// Moves factors common to all terms of a value into its users, until the remaining value is in range or
/// between 0 and the users' valuation. Returns whether anything moved.
fn take_apart(
    network: &mut Network,
    valuations: &mut Vec<Valuation>,
    users: &mut Vec<Vec<Atom>>,
    atom: Atom,
    wanted: Valuation,
) -> bool {
    let Value::Sum(sum) = &network.values[atom as usize] else { return false };
    let mut products = sum.monomials().map(|monomial| network.monomials.atoms(monomial));
    let Some(first) = products.next() else { return false };
    let mut shared = first.to_vec();
    for product in products {
        let mut rest = product.to_vec();
        shared.retain(|x| rest.iter().position(|y| x == y).map(|place| rest.remove(place)).is_some());
    }
    let mut given = Vec::new();
    let mut left = valuations[atom as usize];
    for factor in shared {
        let valuation = valuations[factor as usize];
        if !left.is_on_the_way_to(wanted) && (left + -valuation).size() < left.size() {
            left = left + -valuation;
            given.push(factor);
        }
    }
    if given.is_empty() {
        return false;
    }
    let mut rest = Polynomial::new();
    let monomials = &mut network.monomials;
    for (m, c) in sum.terms() {
        let mut factors = monomials.quotient(monomials.atoms(*m), &given).expect("every term has it");
        rest.add(monomials.intern(&mut factors), c);
    }
    valuations.push(network.valuation_of_sum(&rest, valuations));
    let left = network.define(Value::Sum(rest));
    users.push(Vec::new());
    network.each_operand(left, |operand| users[operand as usize].push(left));
    given.push(left);
    for user in std::mem::take(&mut users[atom as usize]) {
        let Value::Sum(sum) = &network.values[user as usize] else { continue };
        let mut sum = sum.clone();
        let monomials = &mut network.monomials;
        while let Some((monomial, c)) = sum.take_first(|m| monomials.atoms(m).contains(&atom)) {
            let mut factors = monomials.quotient(monomials.atoms(monomial), &[atom]).expect("it is held");
            factors.extend_from_slice(&given);
            sum.add(monomials.intern(&mut factors), &c);
        }
        network.values[user as usize] = Value::Sum(sum);
        given.iter().for_each(|factor| users[*factor as usize].push(user));
    }
    true
}
