//! Factoring by fast extraction: makes values of the two-term sums and two-factor products that save most
//! operations.
//!
//! In and out: a [`Network`]. Every pair of terms of a sum is a candidate divisor with its cofactor, every
//! pair of factors of a product a candidate product. A heap orders the candidates by exact saving; after each
//! extraction the affected candidates are scored again. Sums are never multiplied out. No product becomes a
//! value if floats would overflow or underflow where positions coincide. A step limit bounds the work.

use crate::math::exact::Exact;
use crate::optimize::network::{Network, Value};
use crate::optimize::polynomial::{Atom, Monomial, Polynomial};
use crate::scalar::valuation::Valuation;
use smallvec::SmallVec;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// first + ratio · second
#[derive(Clone, PartialEq, Eq, Hash)]
struct Divisor {
    first: Monomial,
    second: Monomial,
    /// ±1 in nearly all cases.
    ratio: Exact,
}

/// A place where a divisor applies: two terms of a sum, and the saving from the divisor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Use {
    user: Atom,
    /// The two terms, in the order of the sum.
    terms: [Monomial; 2],
    /// Whether the second term matches the divisor's first.
    swapped: bool,
    saving: i32,
}

#[derive(Default)]
struct Candidate {
    /// Sorted, so that the uses of one user are adjacent.
    uses: SmallVec<[Use; 1]>,
    rank: Rank,
}

#[derive(Default)]
struct Pair {
    /// The products that contain both factors, with their sums; sorted.
    uses: SmallVec<[(Atom, Monomial); 2]>,
    rank: Rank,
}

/// Whether an element is inserted into a table or removed.
#[derive(Clone, Copy)]
enum Step {
    Enter,
    Leave,
}

impl Step {
    /// Inserts into or removes from a sorted list; returns whether the list changed.
    fn apply<A: smallvec::Array<Item: Ord>>(self, list: &mut SmallVec<A>, element: A::Item) -> bool {
        match (self, list.binary_search(&element)) {
            (Step::Enter, Err(i)) => list.insert(i, element),
            (Step::Leave, Ok(i)) => drop(list.remove(i)),
            _ => return false,
        }
        true
    }
}

/// The priority of a candidate, packed into a number: by saving, then number of places, then smaller size,
/// then age; divisors before products. Zero means no candidate.
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

/// The kind (whether it is a pair) and the number of the candidate of a rank.
fn ranked(rank: Rank) -> (bool, u32) {
    (rank >> 32 & 1 == 0, !(rank as u32))
}

struct Extraction<'n> {
    network: &'n mut Network,
    /// The valuation of each atom.
    valuations: Vec<Valuation>,
    divisors: indexmap::IndexMap<Divisor, Candidate, rustc_hash::FxBuildHasher>,
    pairs: indexmap::IndexMap<(Atom, Atom), Pair, rustc_hash::FxBuildHasher>,
    heap: BinaryHeap<Rank>,
    /// The divisors and the pairs whose uses changed since the last scoring.
    changed: [Vec<u32>; 2],
    /// Buffers for `tell_apart`: the factors that only the first or only the second term has.
    only: [Vec<Atom>; 2],
}

/// Factors a network, in at most `steps` extractions.
pub fn extract(network: &mut Network, steps: usize) {
    network.sweep();
    let mut extraction = Extraction {
        valuations: network.valuations(),
        network,
        divisors: Default::default(),
        pairs: Default::default(),
        heap: BinaryHeap::new(),
        changed: Default::default(),
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

/// The number of multiplications in one term.
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

    /// Adds the candidates of a sum to the tables.
    fn index(&mut self, atom: Atom) {
        let Value::Sum(polynomial) = &mut self.network.values[atom as usize] else { return };
        let whole = std::mem::take(polynomial);
        let mut polynomial = Polynomial::new();
        for (monomial, coefficient) in whole.terms() {
            self.step(Step::Enter, atom, &polynomial, *monomial, coefficient);
            polynomial.add(*monomial, coefficient);
        }
        self.network.values[atom as usize] = Value::Sum(polynomial);
    }

    /// Adds or removes the candidates that a term forms with the terms of a sum.
    fn step(&mut self, step: Step, atom: Atom, rest: &Polynomial, m: Monomial, c: &Exact) {
        for (n, d) in rest.terms() {
            let (divisor, place) = if m < *n {
                self.divisor(atom, (m, c), (*n, d))
            } else {
                self.divisor(atom, (*n, d), (m, c))
            };
            let entry = self.divisors.entry(divisor);
            let number = entry.index() as u32;
            if step.apply(&mut entry.or_default().uses, place) {
                self.changed[0].push(number);
            }
        }
        let atoms = self.network.monomials.atoms(m);
        for (j, &x) in atoms.iter().enumerate() {
            for &y in &atoms[j + 1..] {
                let entry = self.pairs.entry((x, y));
                let number = entry.index() as u32;
                if step.apply(&mut entry.or_default().uses, (atom, m)) {
                    self.changed[1].push(number);
                }
            }
        }
    }

    fn add_term(&mut self, atom: Atom, polynomial: &mut Polynomial, m: Monomial, c: &Exact) {
        let c = match self.remove_term(atom, polynomial, m) {
            Some(before) => &before + c,
            None => c.clone(),
        };
        if !c.is_zero() {
            self.step(Step::Enter, atom, polynomial, m, &c);
            polynomial.add(m, &c);
        }
    }

    fn remove_term(&mut self, atom: Atom, polynomial: &mut Polynomial, m: Monomial) -> Option<Exact> {
        let c = polynomial.remove(m)?;
        self.step(Step::Leave, atom, polynomial, m, &c);
        Some(c)
    }

    /// The divisor of two terms of a sum, and its use there.
    fn divisor(
        &mut self,
        user: Atom,
        (m, c): (Monomial, &Exact),
        (n, d): (Monomial, &Exact),
    ) -> (Divisor, Use) {
        let terms = [m, n];
        let monomials = &mut self.network.monomials;
        let (a, b) = (monomials.atoms(m), monomials.atoms(n));
        let before = term_cost(a.len(), c) + term_cost(b.len(), d) + 1;
        let [first, second] = &mut self.only;
        let common = tell_apart(a, b, first, second);
        let swapped = first > second;
        let (first, second) =
            if common == 0 { (m, n) } else { (monomials.intern(first), monomials.intern(second)) };
        let ((first, c), (second, d)) =
            if swapped { ((second, d), (first, c)) } else { ((first, c), (second, d)) };
        let ratio = if c.is_one() { d.clone() } else { d * &c.recip() };
        let saving = (before - common as i64 - i64::from(!c.is_unit())) as i32;
        (Divisor { first, second, ratio }, Use { user, terms, swapped, saving })
    }

    /// Scores the candidates that changed.
    fn score(&mut self) {
        let [mut divisors, mut pairs] = std::mem::take(&mut self.changed);
        for numbers in [&mut divisors, &mut pairs] {
            numbers.sort_unstable();
            numbers.dedup();
        }
        for number in divisors.drain(..) {
            let (saving, places) = self.saving(number);
            let suits = saving > 0 && self.suits(number);
            let (divisor, candidate) =
                self.divisors.get_index_mut(number as usize).expect("numbers are positions");
            let mut now = 0;
            if suits {
                let monomials = &self.network.monomials;
                let size = monomials.degree(divisor.first) + monomials.degree(divisor.second);
                now = rank(saving, places, size, false, number);
            }
            if std::mem::replace(&mut candidate.rank, now) != now && now != 0 {
                self.heap.push(now);
            }
        }
        for number in pairs.drain(..) {
            let (&(x, y), pair) = self.pairs.get_index(number as usize).expect("numbers are positions");
            let saving = pair.uses.len() as i64 - 1;
            let own = self.valuations[x as usize] + self.valuations[y as usize];
            let users = pair.uses.iter().map(|(_, product)| self.valuation(*product));
            let suits = saving > 0 && own.suits(users);
            let pair = &mut self.pairs[number as usize];
            let now = if suits { rank(saving, 0, 0, true, number) } else { 0 };
            if std::mem::replace(&mut pair.rank, now) != now && now != 0 {
                self.heap.push(now);
            }
        }
        self.changed = [divisors, pairs];
    }

    /// The valuation of a product.
    fn valuation(&self, product: Monomial) -> Valuation {
        self.network.monomials.atoms(product).iter().map(|x| self.valuations[*x as usize]).sum()
    }

    /// Whether floats can represent the divisor, or none of its uses.
    fn suits(&self, number: u32) -> bool {
        let (divisor, candidate) = self.divisors.get_index(number as usize).expect("numbers are positions");
        let least = |[first, second]: [Monomial; 2]| self.valuation(first).min(self.valuation(second));
        least([divisor.first, divisor.second]).suits(candidate.uses.iter().map(|place| least(place.terms)))
    }

    /// The exact saving of a divisor and the number of places it applies to.
    fn saving(&self, number: u32) -> (i64, usize) {
        let (divisor, candidate) = self.divisors.get_index(number as usize).expect("numbers are positions");
        let (mut saving, mut places) = (0, 0);
        // Each term is used once.
        let mut served: Vec<Monomial> = Vec::new();
        let mut uses = candidate.uses.iter().peekable();
        while let Some(place) = uses.next() {
            if !place.terms.iter().any(|term| served.contains(term)) {
                saving += i64::from(place.saving);
                places += 1;
                served.extend(place.terms);
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

    /// Takes a sum out of the network, to rewrite it.
    fn take(&mut self, atom: Atom) -> Polynomial {
        match &mut self.network.values[atom as usize] {
            Value::Sum(polynomial) => std::mem::take(polynomial),
            _ => unreachable!("users are sums"),
        }
    }

    /// Defines a value, or finds a user that has this value already, up to sign.
    fn define(&mut self, definition: Polynomial, users: impl Iterator<Item = Atom>) -> (Atom, bool, bool) {
        let opposite = definition.negated();
        for user in users {
            let polynomial = self.polynomial(user);
            if polynomial == Some(&definition) || polynomial == Some(&opposite) {
                return (user, polynomial == Some(&opposite), true);
            }
        }
        self.valuations.push(self.network.valuation_of_sum(&definition, &self.valuations));
        (self.network.define(Value::Sum(definition)), false, false)
    }

    fn take_divisor(&mut self, number: u32) {
        let (divisor, candidate) =
            self.divisors.get_index_mut(number as usize).expect("numbers are positions");
        let divisor = divisor.clone();
        let uses = candidate.uses.clone();
        let definition = Polynomial::from([(divisor.first, Exact::ONE), (divisor.second, divisor.ratio)]);
        let (target, negative, existed) = self.define(definition, uses.iter().map(|place| place.user));
        for uses in uses.chunk_by(|a, b| a.user == b.user) {
            let user = uses[0].user;
            if user == target {
                continue;
            }
            let mut polynomial = self.take(user);
            for place in uses {
                if place.terms.iter().any(|term| polynomial.get(*term).is_none()) {
                    continue;
                }
                let [first, second] =
                    if place.swapped { [place.terms[1], place.terms[0]] } else { place.terms };
                let coefficient = self.remove_term(user, &mut polynomial, first).expect("just seen");
                self.remove_term(user, &mut polynomial, second);
                let monomials = &mut self.network.monomials;
                let mut atoms = monomials
                    .quotient(monomials.atoms(first), monomials.atoms(divisor.first))
                    .expect("a use is a multiple");
                atoms.push(target);
                let monomial = monomials.intern(&mut atoms);
                let coefficient = if negative { -coefficient } else { coefficient };
                self.add_term(user, &mut polynomial, monomial, &coefficient);
            }
            self.network.values[user as usize] = Value::Sum(polynomial);
        }
        if !existed {
            self.index(target);
        }
    }

    fn take_pair(&mut self, number: u32) {
        let (&(x, y), pair) = self.pairs.get_index_mut(number as usize).expect("numbers are positions");
        let uses = pair.uses.clone();
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
                let Some(mut coefficient) = self.remove_term(user, &mut polynomial, monomial) else {
                    continue;
                };
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
                self.add_term(user, &mut polynomial, monomial, &coefficient);
            }
            self.network.values[user as usize] = Value::Sum(polynomial);
        }
        if !existed {
            self.index(target);
        }
    }
}

/// Splits two products into the factors that only one of them has; returns the number of common factors.
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
