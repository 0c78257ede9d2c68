//! Factoring by fast extraction: the two-term sums and two-factor products that save most become values of their own.
//!
//! In and out: a [`Network`]. Every pair of terms of every sum is a candidate divisor with its cofactor, every pair of
//! factors of every product a candidate product; the exact saving of each is kept in a heap, the best is taken, what it
//! touches is scored again. Sums are never multiplied out. Work is bounded in steps, not in time.

use super::network::{Atom, Monomial, Network, Polynomial, Value, add_term};
use crate::exact::Exact;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// a + ratio · b
#[derive(Clone, PartialEq, Eq, Hash)]
struct Divisor {
    first: Monomial,
    second: Monomial,
    ratio: Ratio,
}

/// One coefficient over another; nearly always a sign.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Ratio {
    Same,
    Opposite,
    Other(Exact),
}

impl Ratio {
    fn of(a: &Exact, b: &Exact) -> Ratio {
        if a == b {
            return Ratio::Same;
        }
        let ratio = if b.is_one() { a.clone() } else { a * &b.recip() };
        if ratio == -Exact::ONE { Ratio::Opposite } else { Ratio::Other(ratio) }
    }

    fn value(&self) -> Exact {
        match self {
            Ratio::Same => Exact::ONE,
            Ratio::Opposite => -Exact::ONE,
            Ratio::Other(ratio) => ratio.clone(),
        }
    }
}

#[derive(Default)]
struct Candidate {
    /// The users with the pairs of their terms that are a multiple of the divisor, a user's uses together.
    uses: Vec<(Atom, Monomial, Monomial)>,
    version: u32,
}

#[derive(Default)]
struct Pair {
    /// The products of sums that hold both factors, a user's uses together.
    uses: Vec<(Atom, Monomial)>,
    version: u32,
}

/// Ordered by saving, then by the number of places, then the simpler and the older first.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Scored {
    saving: i64,
    places: usize,
    size: Reverse<usize>,
    age: Reverse<(bool, u32)>,
    version: u32,
}

/// The numbers of the divisors and of the pairs that one sum offers.
type Candidates = (Vec<u32>, Vec<u32>);

struct Extraction<'n> {
    network: &'n mut Network,
    divisors: indexmap::IndexMap<Divisor, Candidate, rustc_hash::FxBuildHasher>,
    pairs: indexmap::IndexMap<(Atom, Atom), Pair, rustc_hash::FxBuildHasher>,
    /// The candidates each user takes part in.
    of_user: FxHashMap<Atom, Candidates>,
    heap: BinaryHeap<Scored>,
    dirty_divisors: BTreeSet<u32>,
    dirty_pairs: BTreeSet<u32>,
}

/// Factors a network, at most this many steps.
pub fn extract(network: &mut Network, steps: usize) {
    network.sweep();
    let mut extraction = Extraction {
        network,
        divisors: Default::default(),
        pairs: Default::default(),
        of_user: FxHashMap::default(),
        heap: BinaryHeap::new(),
        dirty_divisors: BTreeSet::new(),
        dirty_pairs: BTreeSet::new(),
    };
    for atom in extraction.network.order() {
        extraction.index(atom);
    }
    extraction.score();
    let mut taken = 0;
    while taken < steps {
        let Some(best) = extraction.heap.pop() else { break };
        let Reverse((is_pair, number)) = best.age;
        let version = if is_pair {
            extraction.pairs[number as usize].version
        } else {
            extraction.divisors[number as usize].version
        };
        if version != best.version {
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
        let Some(polynomial) = self.polynomial(atom) else { return };
        let terms: Vec<(Monomial, Exact)> = polynomial.iter().map(|(m, c)| (*m, c.clone())).collect();
        let mut divisors = Vec::new();
        let mut pairs = Vec::new();
        for (i, (mi, ci)) in terms.iter().enumerate() {
            for (mj, cj) in &terms[i + 1..] {
                let (divisor, pair) = self.divisor((*mi, ci), (*mj, cj));
                let entry = self.divisors.entry(divisor);
                let number = entry.index() as u32;
                entry.or_default().uses.push((atom, pair.0, pair.1));
                divisors.push(number);
            }
            let atoms = self.network.monomials.atoms(*mi).to_vec();
            for (j, &x) in atoms.iter().enumerate() {
                for &y in &atoms[j + 1..] {
                    let entry = self.pairs.entry((x, y));
                    let number = entry.index() as u32;
                    let uses = &mut entry.or_default().uses;
                    if uses.last() != Some(&(atom, *mi)) {
                        uses.push((atom, *mi));
                    }
                    pairs.push(number);
                }
            }
        }
        self.dirty_divisors.extend(&divisors);
        self.dirty_pairs.extend(&pairs);
        self.of_user.insert(atom, (divisors, pairs));
    }

    fn unindex(&mut self, atom: Atom) {
        let Some((divisors, pairs)) = self.of_user.remove(&atom) else { return };
        for &number in &divisors {
            self.divisors[number as usize].uses.retain(|(user, ..)| *user != atom);
        }
        for &number in &pairs {
            self.pairs[number as usize].uses.retain(|(user, _)| *user != atom);
            self.dirty_pairs.insert(number);
        }
        self.dirty_divisors.extend(divisors);
    }

    /// The divisor of two terms, and the terms in its order.
    fn divisor(
        &mut self,
        (mi, ci): (Monomial, &Exact),
        (mj, cj): (Monomial, &Exact),
    ) -> (Divisor, (Monomial, Monomial)) {
        let (a, b) = (self.network.monomials.atoms(mi), self.network.monomials.atoms(mj));
        let (mut i, mut j) = (0, 0);
        let (mut first, mut second) = (Vec::new(), Vec::new());
        while i < a.len() || j < b.len() {
            if j == b.len() || i < a.len() && a[i] < b[j] {
                first.push(a[i]);
                i += 1;
            } else if i == a.len() || b[j] < a[i] {
                second.push(b[j]);
                j += 1;
            } else {
                (i, j) = (i + 1, j + 1);
            }
        }
        if first < second {
            let (first, second) =
                (self.network.monomials.intern(first), self.network.monomials.intern(second));
            (Divisor { first, second, ratio: Ratio::of(cj, ci) }, (mi, mj))
        } else {
            let (first, second) =
                (self.network.monomials.intern(second), self.network.monomials.intern(first));
            (Divisor { first, second, ratio: Ratio::of(ci, cj) }, (mj, mi))
        }
    }

    /// Scores what has changed.
    fn score(&mut self) {
        for number in std::mem::take(&mut self.dirty_divisors) {
            let (saving, places) = self.saving(number);
            let (divisor, candidate) =
                self.divisors.get_index_mut(number as usize).expect("numbers are positions");
            candidate.version += 1;
            if saving > 0 {
                let monomials = &self.network.monomials;
                let size = monomials.degree(divisor.first) + monomials.degree(divisor.second);
                let version = candidate.version;
                self.heap.push(Scored {
                    saving,
                    places,
                    size: Reverse(size),
                    age: Reverse((false, number)),
                    version,
                });
            }
        }
        for number in std::mem::take(&mut self.dirty_pairs) {
            let pair = &mut self.pairs[number as usize];
            pair.version += 1;
            let saving = pair.uses.len() as i64 - 1;
            if saving > 0 {
                let version = pair.version;
                self.heap.push(Scored {
                    saving,
                    places: 0,
                    size: Reverse(0),
                    age: Reverse((true, number)),
                    version,
                });
            }
        }
    }

    /// The exact saving of a divisor and the number of places it serves.
    fn saving(&self, number: u32) -> (i64, usize) {
        let (divisor, candidate) = self.divisors.get_index(number as usize).expect("numbers are positions");
        let monomials = &self.network.monomials;
        let degree = monomials.degree(divisor.first);
        let (mut saving, mut places) = (0, 0);
        let mut used: Vec<Monomial> = Vec::new();
        let mut user = None;
        for (atom, first, second) in &candidate.uses {
            if user != Some(*atom) {
                user = Some(*atom);
                used.clear();
            }
            if used.contains(first) || used.contains(second) {
                continue;
            }
            used.extend([*first, *second]);
            let polynomial = self.polynomial(*atom).expect("users are sums");
            let (a, b) = (&polynomial[first], &polynomial[second]);
            let before = term_cost(monomials.degree(*first), a) + term_cost(monomials.degree(*second), b) + 1;
            let after = (monomials.degree(*first) - degree) as i64 + i64::from(!a.is_unit());
            saving += before - after;
            places += 1;
        }
        let own = 1
            + monomials.degree(divisor.first).saturating_sub(1)
            + monomials.degree(divisor.second).saturating_sub(1)
            + usize::from(matches!(divisor.ratio, Ratio::Other(_)));
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

    fn take_divisor(&mut self, number: u32) {
        let (divisor, candidate) =
            self.divisors.get_index_mut(number as usize).expect("numbers are positions");
        let divisor = divisor.clone();
        let mut uses: BTreeMap<Atom, Vec<(Monomial, Monomial)>> = BTreeMap::new();
        for (atom, first, second) in std::mem::take(&mut candidate.uses) {
            uses.entry(atom).or_default().push((first, second));
        }
        self.dirty_divisors.insert(number);
        let definition =
            Polynomial::from([(divisor.first, Exact::ONE), (divisor.second, divisor.ratio.value())]);
        let opposite: Polynomial = definition.iter().map(|(m, c)| (*m, -c)).collect();
        let existing = uses.keys().find_map(|&atom| {
            let polynomial = self.polynomial(atom)?;
            if *polynomial == definition {
                Some((atom, false))
            } else {
                (*polynomial == opposite).then_some((atom, true))
            }
        });
        let (target, negative) =
            existing.unwrap_or_else(|| (self.network.define(Value::Sum(definition)), false));
        for (atom, terms) in uses {
            if atom == target {
                continue;
            }
            let mut polynomial = self.take(atom);
            for (first, second) in terms {
                if !polynomial.contains_key(&first) || !polynomial.contains_key(&second) {
                    continue;
                }
                let coefficient = polynomial.remove(&first).expect("just seen");
                polynomial.remove(&second);
                let monomials = &mut self.network.monomials;
                let mut atoms = monomials
                    .quotient(monomials.atoms(first), monomials.atoms(divisor.first))
                    .expect("a use is a multiple");
                atoms.push(target);
                let monomial = monomials.intern(atoms);
                add_term(&mut polynomial, monomial, &if negative { -coefficient } else { coefficient });
            }
            self.put(atom, polynomial);
        }
        if existing.is_none() {
            self.index(target);
        }
    }

    fn take_pair(&mut self, number: u32) {
        let (&(x, y), pair) = self.pairs.get_index_mut(number as usize).expect("numbers are positions");
        let uses = std::mem::take(&mut pair.uses);
        self.dirty_pairs.insert(number);
        let product = self.network.monomials.intern(vec![x, y]);
        let definition = Polynomial::from([(product, Exact::ONE)]);
        let existing =
            uses.iter().find_map(|&(atom, _)| (self.polynomial(atom)? == &definition).then_some(atom));
        let target = existing.unwrap_or_else(|| self.network.define(Value::Sum(definition)));
        let mut by_user: BTreeMap<Atom, Vec<Monomial>> = BTreeMap::new();
        for (atom, monomial) in uses {
            by_user.entry(atom).or_default().push(monomial);
        }
        for (atom, products) in by_user {
            if atom == target {
                continue;
            }
            let mut polynomial = self.take(atom);
            for monomial in products {
                let Some(coefficient) = polynomial.remove(&monomial) else { continue };
                let monomials = &mut self.network.monomials;
                let mut atoms = monomials.atoms(monomial).to_vec();
                let pair = if x < y { [x, y] } else { [y, x] };
                while let Some(mut rest) = monomials.quotient(&atoms, &pair) {
                    rest.push(target);
                    rest.sort_unstable();
                    atoms = rest;
                }
                let monomial = monomials.intern(atoms);
                add_term(&mut polynomial, monomial, &coefficient);
            }
            self.put(atom, polynomial);
        }
        if existing.is_none() {
            self.index(target);
        }
    }
}
