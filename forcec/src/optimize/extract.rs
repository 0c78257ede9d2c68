//! Factoring by fast extraction: the two-term sums and two-factor products that save most become values of their own.
//!
//! In and out: a [`Network`]. Every pair of terms of every sum is a candidate divisor with its cofactor, every pair of
//! factors of every product a candidate product; the exact saving of each is kept in a heap, the best is taken, what it
//! touches is scored again. Sums are never multiplied out. Work is bounded in steps, not in time.

use super::network::{Network, Value};
use super::polynomial::{Atom, Monomial, Polynomial};
use crate::exact::Exact;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// first + ratio · second
#[derive(Clone, PartialEq, Eq, Hash)]
struct Divisor {
    first: Monomial,
    second: Monomial,
    /// Nearly always a sign.
    ratio: Exact,
}

/// A place where a divisor could serve: two terms of a sum, and what writing them with it would save.
struct Use {
    user: Atom,
    first: Monomial,
    second: Monomial,
    saving: i32,
}

#[derive(Default)]
struct Candidate {
    /// A user's uses stand together.
    uses: Vec<Use>,
    rank: Rank,
}

#[derive(Default)]
struct Pair {
    /// The products of sums that hold both factors, a user's uses together.
    uses: Vec<(Atom, Monomial)>,
    rank: Rank,
}

/// What the next to take is chosen by, packed into a number: the saving, then the number of places, then the simpler
/// and the older first; divisors before products. Zero is no candidate.
type Rank = u128;

fn rank(saving: i64, places: usize, size: usize, is_pair: bool, number: u32) -> Rank {
    let clamp = |x: usize| x.min(u16::MAX.into()) as u128;
    let parts = [
        (saving as u128, 32),
        (places as u128, 32),
        (clamp(usize::from(u16::MAX) - size), 16),
        (u128::from(!is_pair), 1),
        (u128::from(!number), 32),
    ];
    parts.into_iter().fold(0, |rank, (part, bits)| rank << bits | part)
}

/// The candidate of a rank.
fn ranked(rank: Rank) -> (bool, u32) {
    (rank >> 32 & 1 == 0, !(rank as u32))
}

/// The numbers of the divisors and of the pairs that one sum offers.
#[derive(Default)]
struct Offers {
    divisors: Vec<u32>,
    pairs: Vec<u32>,
}

struct Extraction<'n> {
    network: &'n mut Network,
    divisors: indexmap::IndexMap<Divisor, Candidate, rustc_hash::FxBuildHasher>,
    pairs: indexmap::IndexMap<(Atom, Atom), Pair, rustc_hash::FxBuildHasher>,
    /// What each atom offers.
    offers: Vec<Offers>,
    heap: BinaryHeap<Rank>,
    /// Candidates whose uses have changed since they were scored.
    changed: Offers,
    /// Of the divisor that is being told apart: the factors that only one of its terms has.
    only: [Vec<Atom>; 2],
}

/// Factors a network, at most this many steps.
pub fn extract(network: &mut Network, steps: usize) {
    network.sweep();
    let mut extraction = Extraction {
        network,
        divisors: Default::default(),
        pairs: Default::default(),
        offers: Vec::new(),
        heap: BinaryHeap::new(),
        changed: Offers::default(),
        only: Default::default(),
    };
    for atom in extraction.network.order() {
        extraction.index(atom);
    }
    extraction.score();
    let mut taken = 0;
    while taken < steps {
        let Some(best) = extraction.heap.pop() else { break };
        let (is_pair, number) = ranked(best);
        let place = number as usize;
        let now = if is_pair { extraction.pairs[place].rank } else { extraction.divisors[place].rank };
        if now != best {
            continue;
        }
        taken += 1;
        if is_pair {
            extraction.take_pair(number);
        } else {
            extraction.take_divisor(number);
        }
        extraction.score();
    }
    network.sweep();
}

/// The multiplications of one term.
pub fn term_cost(degree: usize, coefficient: &Exact) -> i64 {
    degree.saturating_sub(1) as i64 + i64::from(degree > 0 && !coefficient.is_unit())
}

impl Extraction<'_> {
    fn polynomial(&self, atom: Atom) -> Option<&Polynomial> {
        match &self.network.values[atom as usize] {
            Value::Sum(polynomial) => Some(polynomial),
            _ => None,
        }
    }

    /// Enters a sum into the tables.
    fn index(&mut self, atom: Atom) {
        let Value::Sum(polynomial) = &mut self.network.values[atom as usize] else { return };
        let polynomial = std::mem::take(polynomial);
        let mut offers = Offers::default();
        for (i, (m, c)) in polynomial.terms().iter().enumerate() {
            for (n, d) in &polynomial.terms()[i + 1..] {
                let (divisor, place) = self.divisor(atom, (*m, c), (*n, d));
                let entry = self.divisors.entry(divisor);
                offers.divisors.push(entry.index() as u32);
                entry.or_default().uses.push(place);
            }
            let atoms = self.network.monomials.atoms(*m);
            for (j, &x) in atoms.iter().enumerate() {
                for &y in &atoms[j + 1..] {
                    let entry = self.pairs.entry((x, y));
                    offers.pairs.push(entry.index() as u32);
                    let uses = &mut entry.or_default().uses;
                    if uses.last() != Some(&(atom, *m)) {
                        uses.push((atom, *m));
                    }
                }
            }
        }
        self.network.values[atom as usize] = Value::Sum(polynomial);
        self.changed.divisors.extend(&offers.divisors);
        self.changed.pairs.extend(&offers.pairs);
        if self.offers.len() <= atom as usize {
            self.offers.resize_with(self.network.values.len(), Offers::default);
        }
        self.offers[atom as usize] = offers;
    }

    fn unindex(&mut self, atom: Atom) {
        let Some(offers) = self.offers.get_mut(atom as usize).map(std::mem::take) else { return };
        for &number in &offers.divisors {
            self.divisors[number as usize].uses.retain(|place| place.user != atom);
        }
        for &number in &offers.pairs {
            self.pairs[number as usize].uses.retain(|(user, _)| *user != atom);
        }
        self.changed.divisors.extend(offers.divisors);
        self.changed.pairs.extend(offers.pairs);
    }

    /// The divisor of two terms of a sum, and the place it has there.
    fn divisor(
        &mut self,
        user: Atom,
        (m, c): (Monomial, &Exact),
        (n, d): (Monomial, &Exact),
    ) -> (Divisor, Use) {
        let monomials = &mut self.network.monomials;
        let (a, b) = (monomials.atoms(m), monomials.atoms(n));
        let before = term_cost(a.len(), c) + term_cost(b.len(), d) + 1;
        let [first, second] = &mut self.only;
        let common = tell_apart(a, b, first, second);
        let swapped = first > second;
        let (first, second) =
            if common == 0 { (m, n) } else { (monomials.intern(first), monomials.intern(second)) };
        let ((first, m, c), (second, n, d)) =
            if swapped { ((second, n, d), (first, m, c)) } else { ((first, m, c), (second, n, d)) };
        let ratio = if c.is_one() { d.clone() } else { d * &c.recip() };
        let saving = (before - common as i64 - i64::from(!c.is_unit())) as i32;
        (Divisor { first, second, ratio }, Use { user, first: m, second: n, saving })
    }

    /// Scores what has changed.
    fn score(&mut self) {
        let mut changed = std::mem::take(&mut self.changed);
        for numbers in [&mut changed.divisors, &mut changed.pairs] {
            numbers.sort_unstable();
            numbers.dedup();
        }
        for number in changed.divisors.drain(..) {
            let (saving, places) = self.saving(number);
            let (divisor, candidate) =
                self.divisors.get_index_mut(number as usize).expect("numbers are positions");
            let mut now = 0;
            if saving > 0 {
                let monomials = &self.network.monomials;
                let size = monomials.degree(divisor.first) + monomials.degree(divisor.second);
                now = rank(saving, places, size, false, number);
            }
            if std::mem::replace(&mut candidate.rank, now) != now && now != 0 {
                self.heap.push(now);
            }
        }
        for number in changed.pairs.drain(..) {
            let pair = &mut self.pairs[number as usize];
            let saving = pair.uses.len() as i64 - 1;
            let now = if saving > 0 { rank(saving, 0, 0, true, number) } else { 0 };
            if std::mem::replace(&mut pair.rank, now) != now && now != 0 {
                self.heap.push(now);
            }
        }
        self.changed = changed;
    }

    /// The exact saving of a divisor and the number of places it serves.
    fn saving(&self, number: u32) -> (i64, usize) {
        let (divisor, candidate) = self.divisors.get_index(number as usize).expect("numbers are positions");
        let (mut saving, mut places) = (0, 0);
        // A term serves once.
        let mut served: Vec<Monomial> = Vec::new();
        let mut uses = candidate.uses.iter().peekable();
        while let Some(place) = uses.next() {
            if !served.contains(&place.first) && !served.contains(&place.second) {
                saving += i64::from(place.saving);
                places += 1;
                served.extend([place.first, place.second]);
            }
            if uses.peek().is_none_or(|next| next.user != place.user) {
                served.clear();
            }
        }
        let monomials = &self.network.monomials;
        let own = 1
            + monomials.degree(divisor.first).saturating_sub(1)
            + monomials.degree(divisor.second).saturating_sub(1)
            + usize::from(!divisor.ratio.is_unit());
        (saving - own as i64, places)
    }

    /// Takes a sum out to be rewritten; [`Extraction::put`] enters it again.
    fn take(&mut self, atom: Atom) -> Polynomial {
        self.unindex(atom);
        match std::mem::replace(&mut self.network.values[atom as usize], Value::Dead) {
            Value::Sum(polynomial) => polynomial,
            _ => unreachable!("users are sums"),
        }
    }

    fn put(&mut self, atom: Atom, polynomial: Polynomial) {
        self.network.values[atom as usize] = Value::Sum(polynomial);
        self.index(atom);
    }

    /// Defines a value, or finds the user that is this value already, up to sign.
    fn define(&mut self, definition: Polynomial, users: impl Iterator<Item = Atom>) -> (Atom, bool, bool) {
        let opposite = definition.negated();
        for user in users {
            let polynomial = self.polynomial(user);
            if polynomial == Some(&definition) || polynomial == Some(&opposite) {
                return (user, polynomial == Some(&opposite), true);
            }
        }
        (self.network.define(Value::Sum(definition)), false, false)
    }

    fn take_divisor(&mut self, number: u32) {
        let (divisor, candidate) =
            self.divisors.get_index_mut(number as usize).expect("numbers are positions");
        let divisor = divisor.clone();
        let mut uses = std::mem::take(&mut candidate.uses);
        uses.sort_by_key(|place| place.user);
        self.changed.divisors.push(number);
        let definition = Polynomial::from([(divisor.first, Exact::ONE), (divisor.second, divisor.ratio)]);
        let (target, negative, existed) = self.define(definition, uses.iter().map(|place| place.user));
        for uses in uses.chunk_by(|a, b| a.user == b.user) {
            let user = uses[0].user;
            if user == target {
                continue;
            }
            let mut polynomial = self.take(user);
            for place in uses {
                if polynomial.get(place.first).is_none() || polynomial.get(place.second).is_none() {
                    continue;
                }
                let coefficient = polynomial.remove(place.first).expect("just seen");
                polynomial.remove(place.second);
                let monomials = &mut self.network.monomials;
                let mut atoms = monomials
                    .quotient(monomials.atoms(place.first), monomials.atoms(divisor.first))
                    .expect("a use is a multiple");
                atoms.push(target);
                let monomial = monomials.intern(&mut atoms);
                polynomial.add(monomial, &if negative { -coefficient } else { coefficient });
            }
            self.put(user, polynomial);
        }
        if !existed {
            self.index(target);
        }
    }

    fn take_pair(&mut self, number: u32) {
        let (&(x, y), pair) = self.pairs.get_index_mut(number as usize).expect("numbers are positions");
        let mut uses = std::mem::take(&mut pair.uses);
        uses.sort_by_key(|(user, _)| *user);
        self.changed.pairs.push(number);
        let both = [x.min(y), x.max(y)];
        let product = self.network.monomials.intern(&mut both.clone());
        let definition = Polynomial::from([(product, Exact::ONE)]);
        let (target, negative, existed) = self.define(definition, uses.iter().map(|(user, _)| *user));
        for uses in uses.chunk_by(|a, b| a.0 == b.0) {
            let user = uses[0].0;
            if user == target {
                continue;
            }
            let mut polynomial = self.take(user);
            for &(_, monomial) in uses {
                let Some(mut coefficient) = polynomial.remove(monomial) else { continue };
                let monomials = &mut self.network.monomials;
                let mut atoms = monomials.atoms(monomial).to_vec();
                while let Some(mut rest) = monomials.quotient(&atoms, &both) {
                    rest.push(target);
                    rest.sort_unstable();
                    atoms = rest;
                    if negative {
                        coefficient = -coefficient;
                    }
                }
                let monomial = monomials.intern(&mut atoms);
                polynomial.add(monomial, &coefficient);
            }
            self.put(user, polynomial);
        }
        if !existed {
            self.index(target);
        }
    }
}

/// Splits two products into what only one of them has; the number of factors they share.
fn tell_apart(a: &[Atom], b: &[Atom], only_a: &mut Vec<Atom>, only_b: &mut Vec<Atom>) -> usize {
    only_a.clear();
    only_b.clear();
    let (mut i, mut j, mut common) = (0, 0, 0);
    while i < a.len() && j < b.len() {
        match a[i].cmp(&b[j]) {
            Ordering::Less => {
                only_a.push(a[i]);
                i += 1;
            }
            Ordering::Greater => {
                only_b.push(b[j]);
                j += 1;
            }
            Ordering::Equal => (i, j, common) = (i + 1, j + 1, common + 1),
        }
    }
    only_a.extend_from_slice(&a[i..]);
    only_b.extend_from_slice(&b[j..]);
    common
}
