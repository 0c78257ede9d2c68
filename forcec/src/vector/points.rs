//! Points, and pinned differences of two points.
//!
//! In: the terms of a sum. Out: the same sum, in which points of opposite signs are paired into difference
//! nodes. Promise: no pass regroups across such a node, so that far from the origin the difference of two
//! positions is one subtraction.

use crate::math::exact::{Exact, collect};
use crate::model::bodies::{Role, Slot};
use crate::vector::{Graph, Node, Real, Vector};

impl Graph {
    /// The slot of a vector that is a point: a position, or three entries of a parameter.
    pub(super) fn point(&self, v: Vector) -> Option<Slot> {
        match *self.vector_at(v) {
            Node::Triple(slot)
                if matches!(self.signature.role(slot), None | Some(Role::Position))
                    && self.signature.extra(slot).is_none() =>
            {
                Some(slot)
            }
            _ => None,
        }
    }

    /// Whether a real is a stored argument entry.
    pub(super) fn is_entry(&self, x: Real) -> bool {
        match *self.at(x) {
            Node::Entry(_) => true,
            Node::Component(v, _) => matches!(self.vector_at(v), Node::Triple(_)),
            _ => false,
        }
    }

    /// The axis and the point of a real that is an entry of a point, with or without an added number.
    fn entry_of_point(&self, x: Real) -> Option<(u8, Slot)> {
        match *self.at(x) {
            Node::Offset(entry, _) => self.entry_of_point(entry),
            Node::Component(v, axis) => self.point(v).map(|slot| (axis, slot)),
            _ => None,
        }
    }

    /// Splits points with added numbers into points and numbers, if the sum has another point to subtract
    /// first.
    pub(super) fn open_offsets(&self, terms: Vec<(Exact, Real)>, constant: &mut Exact) -> Vec<(Exact, Real)> {
        let meets = |(c, x): &(Exact, Real)| {
            let Some((axis, slot)) = self.entry_of_point(*x) else { return false };
            terms.iter().any(|(d, y)| {
                let other = self.entry_of_point(*y);
                c.is_negative() != d.is_negative()
                    && other.is_some_and(|(own, point)| own == axis && point != slot)
            })
        };
        if terms.len() < 2 || !terms.iter().any(meets) {
            return terms;
        }
        let open = |(c, x): &(Exact, Real)| match self.at(*x) {
            Node::Offset(entry, number) if meets(&(c.clone(), *x)) => {
                *constant = &*constant + &(c * number);
                (c.clone(), *entry)
            }
            _ => (c.clone(), *x),
        };
        collect(terms.iter().map(open).collect())
    }

    /// Splits points with added constant vectors in the same way.
    pub(super) fn open_vector_offsets(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let point = |graph: &Graph, v: Vector| match *graph.vector_at(v) {
            Node::VectorOffset(inner, _) => graph.point(inner),
            _ => graph.point(v),
        };
        let meets = |graph: &Graph, (c, v): &(Exact, Vector)| {
            let Some(slot) = point(graph, *v) else { return false };
            let opposite = |(d, w): &(Exact, Vector)| {
                c.is_negative() != d.is_negative() && point(graph, *w).is_some_and(|other| other != slot)
            };
            terms.iter().any(opposite)
        };
        if terms.len() < 2 || !terms.iter().any(|term| meets(self, term)) {
            return terms;
        }
        let mut open = Vec::new();
        for (c, v) in &terms {
            match self.vector_at(*v).clone() {
                Node::VectorOffset(inner, numbers) if meets(self, &(c.clone(), *v)) => {
                    open.push((c.clone(), inner));
                    let place = numbers.map(|number| self.constant(number));
                    open.push((c.clone(), self.pack(place)));
                }
                _ => open.push((c.clone(), *v)),
            }
        }
        collect(open)
    }

    /// The entries of a vector of numbers, if all entries are numbers.
    pub(super) fn place(&self, v: Vector) -> Option<[&Exact; 3]> {
        let Node::Pack([x, y, z]) = *self.vector_at(v) else { return None };
        Some([self.value(x)?, self.value(y)?, self.value(z)?])
    }

    /// The sum of a point and a constant vector as one pinned vector, if the sum has this form.
    pub(super) fn pin_place(&mut self, terms: &[(Exact, Vector)]) -> Option<Vector> {
        let [first, second] = terms else { return None };
        for ((c, v), (d, place)) in [(first, second), (second, first)] {
            let is_triple = matches!(self.vector_at(*v), Node::Triple(_));
            if let Some(numbers) = self.place(*place).filter(|_| is_triple && c.is_power_of_two()) {
                let factor = d * &c.recip();
                let numbers = numbers.map(|number| number * &factor);
                let pinned = self.vector(Node::VectorOffset(*v, Box::new(numbers)));
                return Some(self.vector_sum(vec![(c.clone(), pinned)]));
            }
        }
        None
    }

    /// Whether a sum has as a term an entry of a point, or the length of a position along a vector. Such a
    /// sum is named but not bound by a let, so that the difference of two such sums becomes a difference of
    /// the points.
    pub(super) fn holds_point(&self, sum: Real) -> bool {
        match self.at(sum) {
            Node::Offset(entry, _) => self.entry_of_point(*entry).is_some(),
            Node::Sum(_, terms) => terms.iter().any(|(_, term)| match *self.at(*term) {
                Node::Component(v, _) => self.point(v).is_some(),
                _ => self.measured(*term).is_some(),
            }),
            _ => self.measured(sum).is_some(),
        }
    }

    pub(super) fn pin(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let points: Vec<(Exact, Slot)> =
            terms.iter().filter_map(|(c, v)| self.point(*v).map(|slot| (c.clone(), slot))).collect();
        let paired = pair_points(&points);
        if paired.differences.is_empty() {
            return terms;
        }
        let mut rest: Vec<(Exact, Vector)> =
            terms.into_iter().filter(|(_, v)| self.point(*v).is_none()).collect();
        for (c, first, second) in paired.differences {
            rest.push((c, self.vector(Node::Difference(first, second))));
        }
        for (c, slot) in paired.rest {
            rest.push((c, self.triple(slot)));
        }
        collect(rest)
    }

    /// Pins differences between entries of two points on the same axis, as for whole vectors.
    pub(super) fn pin_components(&mut self, terms: Vec<(Exact, Real)>) -> Vec<(Exact, Real)> {
        for axis in 0..3 {
            let points: Vec<(Exact, Slot)> = terms
                .iter()
                .filter_map(|(c, term)| match *self.at(*term) {
                    Node::Component(v, k) if k == axis => self.point(v).map(|slot| (c.clone(), slot)),
                    _ => None,
                })
                .collect();
            let paired = pair_points(&points);
            if paired.differences.is_empty() {
                continue;
            }
            let mut rest: Vec<(Exact, Real)> = terms
                .into_iter()
                .filter(|(_, term)| match *self.at(*term) {
                    Node::Component(v, k) => k != axis || self.point(v).is_none(),
                    _ => true,
                })
                .collect();
            for (c, first, second) in paired.differences {
                let difference = self.vector(Node::Difference(first, second));
                rest.push((c, self.real(Node::Component(difference, axis))));
            }
            for (c, slot) in paired.rest {
                let point = self.vector(Node::Triple(slot));
                rest.push((c, self.real(Node::Component(point, axis))));
            }
            return self.pin_components(collect(rest));
        }
        terms
    }
}

/// Points of a sum, grouped into differences.
struct Paired {
    differences: Vec<(Exact, Slot, Slot)>,
    rest: Vec<(Exact, Slot)>,
}

/// Groups points of opposite coefficients into pinned differences, the greater slot first, so that x_b − x_a
/// and x_a − x_b are one node. Points without a partner remain terms.
fn pair_points(points: &[(Exact, Slot)]) -> Paired {
    let mut paired = Paired { differences: Vec::new(), rest: points.to_vec() };
    loop {
        let opposite = |a: &Exact, b: &Exact| a.is_negative() != b.is_negative();
        let found = (0..paired.rest.len()).find_map(|i| {
            let (a, _) = &paired.rest[i];
            (i + 1..paired.rest.len()).find(|&j| opposite(a, &paired.rest[j].0)).map(|j| (i, j))
        });
        let Some((i, j)) = found else { return paired };
        let (a, first) = paired.rest[i].clone();
        let (b, second) = paired.rest[j].clone();
        let amount = if a.abs() < b.abs() { a.clone() } else { -&b };
        let (high, low, sign) =
            if first > second { (first, second, amount.clone()) } else { (second, first, -&amount) };
        paired.differences.push((sign, high, low));
        paired.rest[i].0 = &a - &amount;
        paired.rest[j].0 = &b + &amount;
        paired.rest.retain(|(c, _)| !c.is_zero());
    }
}
