//! 3-vectors: sums, multiples, products, lengths, rotations.
//!
//! In: operands. Out: the canonical node of an operation on them; in a verbatim graph, the operation as
//! written. Promise: signs, numbers and real factors move outward, so that vectors that differ only by such
//! factors share a node.

use crate::math::exact::{Exact, collect};
use crate::model::bodies::{Role, Slot};
use crate::vector::{Graph, LONGEST_SUM, Node, Real, Truth, Vector};
use std::collections::BTreeMap;

impl Graph {
    /// Three consecutive argument entries. Numbers that replace the entries are inserted by the lowering, so
    /// that points remain points; only zeros vanish here.
    pub fn triple(&mut self, slot: Slot) -> Vector {
        if self.is_known_zero(slot) {
            return self.zero_vector();
        }
        self.vector(Node::Triple(slot))
    }

    /// Whether three entries are known to be zero.
    fn is_known_zero(&self, slot: Slot) -> bool {
        let zero =
            |offset: u32| self.signature.known(Slot { offset, ..slot }).is_some_and(|value| value.is_zero());
        self.simplify && (slot.offset..slot.offset + 3).all(zero)
    }

    /// The zero vector.
    pub fn zero_vector(&mut self) -> Vector {
        self.vector(Node::VectorSum([].into()))
    }

    /// Whether a vector is identically zero.
    pub fn is_zero_vector(&self, v: Vector) -> bool {
        matches!(self.vector_at(v), Node::VectorSum(terms) if terms.is_empty())
    }

    /// The unit vector along an axis.
    pub fn basis(&mut self, axis: u8) -> Vector {
        let (zero, one) = (self.zero(), self.one());
        let mut entries = [zero; 3];
        entries[axis as usize] = one;
        self.pack(entries)
    }

    /// A vector from its entries.
    pub fn pack(&mut self, entries: [Real; 3]) -> Vector {
        if self.simplify {
            if entries.iter().all(|e| self.is_zero(*e)) {
                return self.zero_vector();
            }
            let parts = entries.map(|e| match *self.at(e) {
                Node::Component(v, axis) => Some((v, axis)),
                _ => None,
            });
            if let [Some((u, 0)), Some((v, 1)), Some((w, 2))] = parts
                && u == v
                && v == w
            {
                return u;
            }
        }
        self.vector(Node::Pack(entries))
    }

    /// An entry of a vector.
    pub fn component(&mut self, v: Vector, axis: u8) -> Real {
        if !self.simplify {
            return self.real(Node::Component(v, axis));
        }
        match self.vector_at(v).clone() {
            Node::Pack(entries) => entries[axis as usize],
            Node::VectorSum(terms) => {
                let terms = terms.iter().map(|(c, v)| (c.clone(), self.component(*v, axis))).collect();
                self.sum(Exact::ZERO, terms)
            }
            Node::Scale(s, v) if matches!(self.vector_at(v), Node::Pack(_)) => {
                let entry = self.component(v, axis);
                self.mul(s, entry)
            }
            Node::VectorOffset(v, numbers) => {
                let entry = self.component(v, axis);
                self.sum(numbers[usize::from(axis)].clone(), vec![(Exact::ONE, entry)])
            }
            _ => self.real(Node::Component(v, axis)),
        }
    }

    /// Splits a vector into coefficient and rest.
    pub fn split_vector(&self, v: Vector) -> (Exact, Vector) {
        match self.vector_at(v) {
            Node::VectorSum(terms) if terms.len() == 1 => terms[0].clone(),
            _ => (Exact::ONE, v),
        }
    }

    /// Σ coefficient · vector. Vectors that differ by a real factor are merged, and differences of points are
    /// pinned.
    pub fn vector_sum(&mut self, terms: Vec<(Exact, Vector)>) -> Vector {
        if !self.simplify {
            return self.vector(Node::VectorSum(terms.into()));
        }
        let mut flat: Vec<(Exact, Vector)> = Vec::new();
        for (coefficient, term) in terms {
            match self.vector_at(term) {
                Node::VectorSum(inner)
                    if inner.len() <= LONGEST_SUM && self.distributes_vector(&coefficient, term) =>
                {
                    flat.extend(inner.iter().map(|(c, v)| (&coefficient * c, *v)))
                }
                _ => flat.push((coefficient, term)),
            }
        }
        let flat = self.open_vector_offsets(collect(flat));
        let flat = self.merge_scales(flat);
        let flat = self.balance(flat);
        let flat = self.pin(flat);
        if let Some(pinned) = self.pin_place(&flat) {
            return pinned;
        }
        match flat.as_slice() {
            [(c, v)] if c.is_one() => *v,
            _ => self.vector(Node::VectorSum(flat.into())),
        }
    }

    /// Whether distributing a coefficient over a sum causes no further rounding, as for reals.
    fn distributes_vector(&self, coefficient: &Exact, sum: Vector) -> bool {
        let Node::VectorSum(terms) = self.vector_at(sum) else { return false };
        let is_point = |(_, v): &(Exact, Vector)| self.point(*v).is_some();
        terms.len() <= 1
            || coefficient.is_power_of_two()
            || terms.iter().any(is_point)
            || self.holds_position(sum)
    }

    /// s v + t v = (s + t) v
    fn merge_scales(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
        let mut groups: BTreeMap<Vector, Vec<(Exact, Option<Real>)>> = BTreeMap::new();
        for (c, v) in &terms {
            match *self.vector_at(*v) {
                Node::Scale(s, inner) => groups.entry(inner).or_default().push((c.clone(), Some(s))),
                _ => groups.entry(*v).or_default().push((c.clone(), None)),
            }
        }
        if groups.len() == terms.len() {
            return terms;
        }
        let mut merged = Vec::new();
        for (v, group) in groups {
            if let [(c, scale)] = group.as_slice() {
                let kept = match scale {
                    Some(s) => self.vector(Node::Scale(*s, v)),
                    None => v,
                };
                merged.push((c.clone(), kept));
                continue;
            }
            let one = self.one();
            let scales = group.into_iter().map(|(c, s)| (c, s.unwrap_or(one))).collect();
            let scale = self.sum(Exact::ZERO, scales);
            let scaled = self.scale(scale, v);
            if !self.is_zero_vector(scaled) {
                merged.push(self.split_vector(scaled));
            }
        }
        collect(merged)
    }

    /// Splits Σ s tᵢ vᵢ into s and Σ tᵢ vᵢ, where s is the product of the factors common to all terms.
    pub fn split_scale(&mut self, v: Vector) -> (Real, Vector) {
        let terms = match self.vector_at(v) {
            Node::Scale(s, inner) => return (*s, *inner),
            Node::VectorSum(terms) => terms.clone(),
            _ => return (self.one(), v),
        };
        let mut common: Option<Vec<(Real, i32)>> = None;
        for (_, term) in &terms {
            let Node::Scale(s, _) = *self.vector_at(*term) else { return (self.one(), v) };
            let factors = self.factors(s);
            common = Some(match common {
                None => factors,
                Some(common) => common
                    .into_iter()
                    .filter_map(|(factor, e)| {
                        let (_, d) = *factors.iter().find(|(other, _)| *other == factor)?;
                        (e.signum() == d.signum()).then_some((factor, e.signum() * e.abs().min(d.abs())))
                    })
                    .collect(),
            });
        }
        let common = common.unwrap_or_default();
        if common.is_empty() {
            return (self.one(), v);
        }
        let inverse: Vec<(Real, i32)> = common.iter().map(|(factor, e)| (*factor, -e)).collect();
        let mut rest = Vec::new();
        for (c, term) in terms {
            let Node::Scale(s, inner) = *self.vector_at(term) else { unreachable!("seen above") };
            let mut factors = self.factors(s);
            factors.extend(&inverse);
            let weight = self.product(&factors);
            rest.push((c.clone(), self.scale(weight, inner)));
        }
        (self.product(&common), self.vector_sum(rest))
    }

    fn factors(&self, s: Real) -> Vec<(Real, i32)> {
        match self.at(s) {
            Node::Product(factors) => factors.to_vec(),
            _ => vec![(s, 1)],
        }
    }

    /// u + v
    pub fn vector_add(&mut self, u: Vector, v: Vector) -> Vector {
        self.vector_sum(vec![(Exact::ONE, u), (Exact::ONE, v)])
    }

    /// u − v
    pub fn vector_sub(&mut self, u: Vector, v: Vector) -> Vector {
        self.vector_sum(vec![(Exact::ONE, u), (-Exact::ONE, v)])
    }

    /// −v
    pub fn vector_neg(&mut self, v: Vector) -> Vector {
        self.vector_sum(vec![(-Exact::ONE, v)])
    }

    /// The difference of two positions, or of two velocities, as a pinned node.
    pub fn difference(&mut self, first: Slot, second: Slot) -> Vector {
        if self.is_known_zero(first) || self.is_known_zero(second) {
            let (first, second) = (self.triple(first), self.triple(second));
            return self.vector_sub(first, second);
        }
        self.vector(Node::Difference(first, second))
    }

    /// s v
    pub fn scale(&mut self, s: Real, v: Vector) -> Vector {
        if !self.simplify {
            return self.vector(Node::Scale(s, v));
        }
        if self.is_zero(s) || self.is_zero_vector(v) {
            return self.zero_vector();
        }
        if let Some(value) = self.value(s) {
            let value = value.clone();
            return self.vector_sum(vec![(value, v)]);
        }
        let (cs, mut s) = self.split(s);
        let (cv, mut v) = self.split_vector(v);
        if let Node::Scale(inner, rest) = *self.vector_at(v) {
            let (c, merged) = {
                let m = self.mul(s, inner);
                self.split(m)
            };
            debug_assert!(!c.is_zero());
            s = merged;
            v = rest;
            let coefficient = &(&cs * &cv) * &c;
            let scaled =
                if self.value(s).is_some() { self.scale(s, v) } else { self.vector(Node::Scale(s, v)) };
            return self.vector_sum(vec![(coefficient, scaled)]);
        }
        let scaled = self.vector(Node::Scale(s, v));
        self.vector_sum(vec![(&cs * &cv, scaled)])
    }

    /// u × v
    pub fn cross(&mut self, u: Vector, v: Vector) -> Vector {
        if !self.simplify {
            return self.vector(Node::Cross(u, v));
        }
        if self.is_zero_vector(u) || self.is_zero_vector(v) {
            return self.zero_vector();
        }
        let (cu, u) = self.split_vector(u);
        let (cv, v) = self.split_vector(v);
        let mut coefficient = &cu * &cv;
        if let Node::Scale(s, inner) = *self.vector_at(u) {
            let cross = self.cross(inner, v);
            let scaled = self.scale(s, cross);
            return self.vector_sum(vec![(coefficient, scaled)]);
        }
        if let Node::Scale(s, inner) = *self.vector_at(v) {
            let cross = self.cross(u, inner);
            let scaled = self.scale(s, cross);
            return self.vector_sum(vec![(coefficient, scaled)]);
        }
        if u == v {
            return self.zero_vector();
        }
        if u > v {
            coefficient = -coefficient;
        }
        let cross = self.vector(Node::Cross(u.min(v), u.max(v)));
        self.vector_sum(vec![(coefficient, cross)])
    }

    /// u · v
    pub fn dot(&mut self, u: Vector, v: Vector) -> Real {
        if !self.simplify {
            return self.real(Node::Dot(u, v));
        }
        if self.is_zero_vector(u) || self.is_zero_vector(v) {
            return self.zero();
        }
        let (cu, u) = self.split_vector(u);
        let (cv, v) = self.split_vector(v);
        let coefficient = &cu * &cv;
        for (p, q) in [(u, v), (v, u)] {
            if let Node::Pack(entries) = *self.vector_at(p)
                && entries.iter().filter(|e| !self.is_zero(**e)).count() == 1
            {
                let axis = (0..3).find(|k| !self.is_zero(entries[*k])).expect("one entry is not zero");
                let entry = self.component(q, axis as u8);
                let product = self.mul(entries[axis], entry);
                return self.scaled(coefficient, product);
            }
            if let Node::Cross(x, y) = *self.vector_at(q) {
                if p == x || p == y {
                    return self.zero();
                }
                if let Some(product) = self.determinant_of_product(p, x, y) {
                    return self.scaled(coefficient, product);
                }
                // ω·(r × f) instead of f·(ω × r): the product of an arm and a force is needed anyway.
                if !self.is_velocity(p) && self.is_velocity(x) {
                    let cross = self.cross(y, p);
                    let product = self.dot(x, cross);
                    return self.scaled(coefficient, product);
                }
                if !self.is_velocity(p) && self.is_velocity(y) {
                    let cross = self.cross(p, x);
                    let product = self.dot(y, cross);
                    return self.scaled(coefficient, product);
                }
            }
        }
        let dot = self.real(Node::Dot(u.min(v), u.max(v)));
        self.scaled(coefficient, dot)
    }

    fn is_velocity(&self, v: Vector) -> bool {
        matches!(*self.vector_at(v), Node::Triple(slot)
            if matches!(self.signature.role(slot), Some(Role::Velocity | Role::AngularVelocity)))
    }

    /// |v|
    pub fn norm(&mut self, v: Vector) -> Real {
        if !self.simplify {
            return self.real(Node::Norm(v));
        }
        if self.is_zero_vector(v) {
            return self.zero();
        }
        let (coefficient, v) = self.split_vector(v);
        let norm = self.real(Node::Norm(v));
        self.scaled(coefficient.abs(), norm)
    }

    /// v/s
    pub fn quotient(&mut self, v: Vector, s: Real) -> Vector {
        if !self.simplify {
            let entries = [0, 1, 2].map(|axis| self.component(v, axis));
            let entries = entries.map(|entry| self.div(entry, s));
            return self.pack(entries);
        }
        let inverse = self.powi(s, -1);
        self.scale(inverse, v)
    }

    /// v/|v|
    pub fn normalize(&mut self, v: Vector) -> Vector {
        let norm = self.norm(v);
        self.quotient(v, norm)
    }

    /// q·v for the quaternion stored at the slot, or q⁻¹·v
    pub fn rotate(&mut self, quaternion: Slot, inverse: bool, v: Vector) -> Vector {
        if !self.simplify {
            return self.vector(Node::Rotate(quaternion, inverse, v));
        }
        if self.is_zero_vector(v) {
            return v;
        }
        let (coefficient, v) = self.split_vector(v);
        if let Node::Scale(s, inner) = *self.vector_at(v) {
            let rotated = self.rotate(quaternion, inverse, inner);
            let scaled = self.scale(s, rotated);
            return self.vector_sum(vec![(coefficient, scaled)]);
        }
        let rotated = match *self.vector_at(v) {
            Node::Rotate(q, i, inner) if q == quaternion && i != inverse && self.unit_quaternions => inner,
            _ => {
                let rotated = self.vector(Node::Rotate(quaternion, inverse, v));
                self.name_arm(rotated, v);
                rotated
            }
        };
        self.vector_sum(vec![(coefficient, rotated)])
    }

    /// The product of one or more stored unit quaternions as (x, y, z) and w.
    pub fn turn(&mut self, turn: &[(Slot, bool)]) -> (Vector, Real) {
        if let [(slot, inverse)] = *turn {
            let vector = self.triple(slot);
            let w = self.entry(Slot { offset: slot.offset + 3, ..slot });
            return (if inverse { self.vector_neg(vector) } else { vector }, w);
        }
        (self.vector(Node::TurnVector(turn.into())), self.real(Node::TurnReal(turn.into())))
    }

    /// if the condition is true u, else v
    pub fn vector_select(&mut self, condition: Truth, u: Vector, v: Vector) -> Vector {
        if self.simplify {
            match *self.truth_at(condition) {
                Node::Known(known) => return if known { u } else { v },
                _ if u == v => return u,
                Node::Not(inner) => return self.vector_select(inner, v, u),
                _ => {}
            }
        }
        self.vector(Node::VectorSelect(condition, u, v))
    }
}
