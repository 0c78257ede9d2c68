//! Sums of weighted, rotated and multiplied positions that do not depend on the origin.
//!
//! In: the terms of a sum, with positions that are multiplied, rotated or crossed with something. Out: the
//! same sum. An operation applied to several positions is applied once to their sum. If the weights of points
//! add up to zero, the weights multiply differences: u a + v b + (1 − u − v) c − p becomes u (a − p) + v (b −
//! p) + (1 − u − v) (c − p). Promise: only sums that depend on a position change, and far from the origin
//! they are as precise as near it.

use crate::math::exact::{Exact, collect};
use crate::model::bodies::{Role, Slot};
use crate::vector::{Graph, Node, Real, Vector};
use std::collections::BTreeMap;

/// Weights whose sum has more terms than this are not tested for a zero sum.
const LONGEST_WEIGHT: usize = 64;

/// Higher powers are not expanded.
const HIGHEST_POWER: i32 = 8;

/// The number of nodes that the search for a position visits.
const DEEPEST: usize = 64;

/// A linear operation on a vector.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Carrier {
    Scale(Real),
    Rotate(Slot, bool),
    Cross(Vector),
}

/// A sum of products of reals.
type Polynomial = BTreeMap<Vec<Real>, Exact>;

impl Graph {
    /// Whether a vector is a position, a linear operation on a position, or a sum with such a term, at
    /// limited depth.
    pub(super) fn holds_position(&self, v: Vector) -> bool {
        let mut open = vec![v];
        for _ in 0..DEEPEST {
            let Some(v) = open.pop() else { return false };
            match *self.vector_at(v) {
                Node::Triple(slot) if self.signature.role(slot) == Some(Role::Position) => return true,
                Node::VectorSum(ref terms) => open.extend(terms.iter().map(|(_, v)| *v)),
                _ => open.extend(self.carried(v).into_iter().map(|(_, _, inner)| inner)),
            }
        }
        false
    }

    /// A vector as ± a linear operation on another vector.
    fn carried(&self, v: Vector) -> Option<(Exact, Carrier, Vector)> {
        let is_open = |v: &Vector| matches!(self.vector_at(*v), Node::Triple(_) | Node::VectorSum(_));
        match *self.vector_at(v) {
            Node::Scale(s, inner) => Some((Exact::ONE, Carrier::Scale(s), inner)),
            Node::Rotate(slot, inverse, inner) => Some((Exact::ONE, Carrier::Rotate(slot, inverse), inner)),
            Node::Cross(u, v) if is_open(&v) => Some((Exact::ONE, Carrier::Cross(u), v)),
            Node::Cross(u, v) if is_open(&u) => Some((-Exact::ONE, Carrier::Cross(v), u)),
            _ => None,
        }
    }

    /// The terms of a sum of vectors; positions are subtracted before any operation on them.
    pub(super) fn balance(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let terms = self.add_packed(terms);
        let behind = |(_, v): &&(Exact, Vector)| self.carried(*v).is_some() && self.holds_position(*v);
        if terms.len() < 2 || terms.iter().find(behind).is_none() {
            return terms;
        }
        let terms = self.carry_together(terms);
        self.weigh_differences(terms)
    }

    /// The terms of a sum of reals, with n·x − n·y as n·(x − y) where the difference contains no position.
    pub(super) fn balance_products(&mut self, terms: Vec<(Exact, Real)>) -> Vec<(Exact, Real)> {
        let mut groups: BTreeMap<Vector, Vec<(Exact, Vector)>> = BTreeMap::new();
        for (c, x) in &terms {
            if let Some((along, position)) = self.measured(*x) {
                groups.entry(along).or_default().push((c.clone(), position));
            }
        }
        groups.retain(|_, group| group.len() > 1);
        let mut joined = Vec::new();
        for (along, group) in groups {
            let apart = self.vector_sum(group);
            if !self.holds_position(apart) {
                joined.push((along, self.dot(along, apart)));
            }
        }
        if joined.is_empty() {
            return terms;
        }
        let is_joined =
            |x: Real| self.measured(x).is_some_and(|(along, _)| joined.iter().any(|(own, _)| *own == along));
        let mut rest: Vec<(Exact, Real)> = terms.into_iter().filter(|(_, x)| !is_joined(*x)).collect();
        rest.extend(joined.into_iter().map(|(_, product)| self.split(product)));
        collect(rest)
    }

    /// The factors of a dot product of a vector that contains no position and a vector that does, in this
    /// order.
    pub(super) fn measured(&self, x: Real) -> Option<(Vector, Vector)> {
        let Node::Dot(u, v) = *self.at(x) else { return None };
        match [u, v].map(|v| self.holds_position(v)) {
            [false, true] => Some((u, v)),
            [true, false] => Some((v, u)),
            _ => None,
        }
    }

    /// Adds vectors packed from such dot products entry by entry.
    fn add_packed(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let measures = |graph: &Graph, v: Vector| match graph.vector_at(v) {
            Node::Pack(entries) => entries.iter().any(|x| graph.measured(*x).is_some()).then_some(*entries),
            _ => None,
        };
        let packed: Vec<(Exact, [Real; 3])> =
            terms.iter().filter_map(|(c, v)| Some((c.clone(), measures(self, *v)?))).collect();
        if packed.len() < 2 {
            return terms;
        }
        let entries = [0, 1, 2].map(|k| {
            let entries = packed.iter().map(|(c, entries)| (c.clone(), entries[k])).collect();
            self.sum(Exact::ZERO, entries)
        });
        let mut rest: Vec<(Exact, Vector)> =
            terms.into_iter().filter(|(_, v)| measures(self, *v).is_none()).collect();
        let sum = self.pack(entries);
        rest.push(self.split_vector(sum));
        collect(rest)
    }

    /// q·x − q·y = q·(x − y), where the difference contains no position.
    fn carry_together(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let mut groups: BTreeMap<Carrier, Vec<(Exact, Vector)>> = BTreeMap::new();
        for (c, v) in &terms {
            if let Some((sign, carrier, inner)) = self.carried(*v).filter(|_| self.holds_position(*v)) {
                groups.entry(carrier).or_default().push((c * &sign, inner));
            }
        }
        groups.retain(|_, group| group.len() > 1);
        let mut joined = Vec::new();
        for (carrier, group) in groups {
            let inner = self.vector_sum(group);
            if !self.holds_position(inner) {
                let vector = match carrier {
                    Carrier::Scale(s) => self.scale(s, inner),
                    Carrier::Rotate(slot, inverse) => self.rotate(slot, inverse, inner),
                    Carrier::Cross(u) => self.cross(u, inner),
                };
                joined.push((carrier, vector));
            }
        }
        let is_joined = |v: Vector| {
            let carrier = self.carried(v).filter(|_| self.holds_position(v)).map(|(_, carrier, _)| carrier);
            joined.iter().any(|(own, _)| Some(*own) == carrier)
        };
        let mut rest: Vec<(Exact, Vector)> = terms.into_iter().filter(|(_, v)| !is_joined(*v)).collect();
        rest.extend(joined.into_iter().map(|(_, vector)| self.split_vector(vector)));
        collect(rest)
    }

    /// Points whose weights add up to zero, as weighted differences from one of the points: a point with a
    /// numeric weight, if there is one.
    fn weigh_differences(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let point = |graph: &Graph, (c, v): &(Exact, Vector)| match *graph.vector_at(*v) {
            Node::Scale(s, inner) => graph.point(inner).map(|slot| (c.clone(), Some(s), slot)),
            _ => graph.point(*v).map(|slot| (c.clone(), None, slot)),
        };
        let (mut points, mut rest) = (Vec::new(), Vec::new());
        for term in &terms {
            match point(self, term) {
                Some(weighted) => points.push(weighted),
                None => rest.push(term.clone()),
            }
        }
        if points.iter().all(|(_, weight, _)| weight.is_none()) || !self.add_up_to_nothing(&points) {
            return terms;
        }
        let place = points.iter().position(|(_, weight, _)| weight.is_none()).unwrap_or(points.len() - 1);
        let origin = points[place].2;
        for (c, weight, slot) in points {
            if slot == origin {
                continue;
            }
            let [slot, origin] = [slot, origin].map(|slot| self.triple(slot));
            let apart = self.vector_sub(slot, origin);
            let weighted = match weight {
                Some(weight) => self.scale(weight, apart),
                None => apart,
            };
            let (sign, weighted) = self.split_vector(weighted);
            rest.push((&c * &sign, weighted));
        }
        collect(rest)
    }

    /// Whether weights add up to zero, however they are named and bracketed.
    fn add_up_to_nothing(&self, points: &[(Exact, Option<Real>, Slot)]) -> bool {
        let mut total = Polynomial::new();
        for (c, weight, _) in points {
            let Some(weight) = weight.map_or_else(|| Some(constant(Exact::ONE)), |x| self.polynomial(x))
            else {
                return false;
            };
            add(&mut total, &weight, c);
        }
        total.is_empty()
    }

    /// The polynomial of a real with products and lets expanded; `None` if the polynomial is too long.
    fn polynomial(&self, real: Real) -> Option<Polynomial> {
        let order = self.below(real)?;
        let mut known: BTreeMap<Real, Polynomial> = BTreeMap::new();
        for x in order {
            let polynomial = match self.at(x) {
                Node::Constant(value) => constant(value.clone()),
                Node::Let(inner) => known[inner].clone(),
                Node::Offset(entry, number) => {
                    let mut sum = constant(number.clone());
                    add(&mut sum, &known[entry], &Exact::ONE);
                    sum
                }
                Node::Sum(number, terms) => {
                    let mut sum = constant(number.clone());
                    terms.iter().for_each(|(c, x)| add(&mut sum, &known[x], c));
                    sum
                }
                Node::Product(factors) if is_short(factors) => {
                    let mut product = constant(Exact::ONE);
                    for (x, exponent) in factors {
                        for _ in 0..*exponent {
                            product = times(&product, &known[x])?;
                        }
                    }
                    product
                }
                _ => Polynomial::from([(vec![x], Exact::ONE)]),
            };
            known.insert(x, polynomial);
        }
        known.remove(&real)
    }

    /// The nodes from which a real is computed as a polynomial, operands before users; `None` if there are
    /// too many.
    fn below(&self, real: Real) -> Option<Vec<Real>> {
        let mut open = vec![real];
        let mut found = std::collections::BTreeSet::new();
        while let Some(x) = open.pop() {
            if !found.insert(x) {
                continue;
            }
            if found.len() > LONGEST_WEIGHT {
                return None;
            }
            match self.at(x) {
                Node::Let(inner) | Node::Offset(inner, _) => open.push(*inner),
                Node::Sum(_, terms) => open.extend(terms.iter().map(|(_, x)| *x)),
                Node::Product(factors) if is_short(factors) => open.extend(factors.iter().map(|(x, _)| *x)),
                _ => {}
            }
        }
        Some(found.into_iter().collect())
    }
}

/// Whether a product is expanded: weights of splines have no higher powers.
fn is_short(factors: &[(Real, i32)]) -> bool {
    factors.iter().all(|(_, exponent)| (1..=HIGHEST_POWER).contains(exponent))
}

fn constant(value: Exact) -> Polynomial {
    if value.is_zero() { Polynomial::new() } else { Polynomial::from([(vec![], value)]) }
}

/// sum += c · other
fn add(sum: &mut Polynomial, other: &Polynomial, c: &Exact) {
    for (monomial, d) in other {
        let entry = sum.entry(monomial.clone()).or_insert(Exact::ZERO);
        *entry = &*entry + &(c * d);
    }
    sum.retain(|_, c| !c.is_zero());
}

fn times(x: &Polynomial, y: &Polynomial) -> Option<Polynomial> {
    let mut product = Polynomial::new();
    for (m, c) in x {
        for (n, d) in y {
            if m.len() + n.len() > LONGEST_WEIGHT {
                return None;
            }
            let mut monomial = [m.as_slice(), n].concat();
            monomial.sort_unstable();
            add(&mut product, &Polynomial::from([(monomial, c * d)]), &Exact::ONE);
        }
        if product.len() > LONGEST_WEIGHT {
            return None;
        }
    }
    Some(product)
}
