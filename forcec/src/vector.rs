//! The vector graph: a force function as the author wrote it, on reals, vectors of three and rotations.
//!
//! One hash-consed arena of typed nodes; ids are `Copy`, operands come before users, so a pass is one loop. The
//! constructors keep nodes canonical: sums collect like terms with exact coefficients, signs and numbers move outward,
//! products merge powers, differences of points are pinned, and an expression that a `let` holds becomes that let.
//! We simplify real numbers and say so: 0·x = 0 and x/x = 1. A graph made by [`Graph::verbatim`] simplifies nothing:
//! it is the source as written, the reference that everything else is checked against.

use crate::bodies::{Role, Signature, Slot};
use crate::exact::Exact;
use crate::identities;
use crate::ops::Function;
use indexmap::IndexSet;
use rustc_hash::{FxBuildHasher, FxHashMap};
use std::collections::BTreeMap;
use std::fmt;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(crate) u32);

        impl $name {
            /// Position in the arena.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}{}", $letter, self.0)
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}{}", $letter, self.0)
            }
        }
    };
}

id!(/// A real-valued node.
    Real, "r");
id!(/// A vector-valued node.
    Vector, "v");
id!(/// A truth-valued node.
    Truth, "b");

/// How two reals are compared.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Comparison {
    /// <
    Less,
    /// ≤
    LessEqual,
    /// =
    Equal,
}

/// A product of stored unit quaternions, left to right, each inverted or not.
pub type Turn = Box<[(Slot, bool)]>;

/// One node.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// A number.
    Constant(Exact),
    /// An entry of an argument.
    Entry(Slot),
    /// constant + Σ coefficient · real
    Sum(Exact, Box<[(Exact, Real)]>),
    /// Π real^exponent
    Product(Box<[(Real, i32)]>),
    /// u · v
    Dot(Vector, Vector),
    /// An entry of a vector, 0, 1 or 2.
    Component(Vector, u8),
    /// |v|
    Norm(Vector),
    /// w of the product of stored unit quaternions, each inverted or not.
    TurnReal(Turn),
    /// A row of the function table.
    Call(Function, Box<[Real]>),
    /// if the condition holds the first, else the second
    Select(Truth, Real, Real),
    /// An intermediate that the author named, or that derivation keeps: opaque to simplification.
    Let(Real),

    /// Three consecutive entries of an argument.
    Triple(Slot),
    /// The pinned difference of two points, first − second: no pass may regroup across it.
    Difference(Slot, Slot),
    /// Σ coefficient · vector; empty is the zero vector
    VectorSum(Box<[(Exact, Vector)]>),
    /// s v
    Scale(Real, Vector),
    /// u × v
    Cross(Vector, Vector),
    /// q·v, or q⁻¹·v when inverse, for the unit quaternion stored at the slot
    Rotate(Slot, bool, Vector),
    /// (x, y, z) of the product of stored unit quaternions.
    TurnVector(Turn),
    /// A vector from its entries.
    Pack([Real; 3]),
    /// if the condition holds the first, else the second
    VectorSelect(Truth, Vector, Vector),
    /// A named intermediate.
    VectorLet(Vector),

    /// A known truth.
    Known(bool),
    /// A comparison.
    Compare(Comparison, Real, Real),
    /// Both.
    And(Truth, Truth),
    /// Either.
    Or(Truth, Truth),
    /// Not.
    Not(Truth),
}

impl Node {
    /// The nodes this one reads, truths included, as positions in the arena.
    pub fn operands(&self) -> Vec<u32> {
        match self {
            Node::Constant(_)
            | Node::Entry(_)
            | Node::Triple(_)
            | Node::TurnReal(_)
            | Node::TurnVector(_)
            | Node::Difference(..)
            | Node::Known(_) => {
                vec![]
            }
            Node::Sum(_, terms) => terms.iter().map(|(_, x)| x.0).collect(),
            Node::Product(factors) => factors.iter().map(|(x, _)| x.0).collect(),
            Node::Dot(u, v) | Node::Cross(u, v) => vec![u.0, v.0],
            Node::Component(v, _) | Node::Norm(v) | Node::Rotate(_, _, v) | Node::VectorLet(v) => vec![v.0],
            Node::Call(_, arguments) => arguments.iter().map(|x| x.0).collect(),
            Node::Select(c, x, y) => vec![c.0, x.0, y.0],
            Node::Let(x) => vec![x.0],
            Node::VectorSum(terms) => terms.iter().map(|(_, v)| v.0).collect(),
            Node::Scale(s, v) => vec![s.0, v.0],
            Node::Pack(entries) => entries.iter().map(|x| x.0).collect(),
            Node::VectorSelect(c, u, v) => vec![c.0, u.0, v.0],
            Node::Compare(_, x, y) => vec![x.0, y.0],
            Node::And(a, b) | Node::Or(a, b) => vec![a.0, b.0],
            Node::Not(a) => vec![a.0],
        }
    }
}

/// The arena.
#[derive(Clone)]
pub struct Graph {
    nodes: IndexSet<Node, FxBuildHasher>,
    /// Definitions that a let holds, and the let.
    held: FxHashMap<u32, u32>,
    /// Names of lets.
    names: BTreeMap<u32, String>,
    /// The arguments that slots refer to.
    pub signature: Signature,
    simplify: bool,
    /// Whether quaternions may be taken as of length one: in derivatives, never in values.
    unit_quaternions: bool,
}

impl Graph {
    /// An empty graph over these arguments.
    pub fn new(signature: Signature) -> Graph {
        Graph {
            nodes: IndexSet::default(),
            held: FxHashMap::default(),
            names: BTreeMap::new(),
            signature,
            simplify: true,
            unit_quaternions: false,
        }
    }

    /// An empty graph that keeps every operation as it is written.
    pub fn verbatim(signature: Signature) -> Graph {
        Graph { simplify: false, ..Graph::new(signature) }
    }

    /// Whether the constructors simplify.
    pub fn simplifies(&self) -> bool {
        self.simplify
    }

    /// From here on quaternions have length one: what follows are derivatives.
    pub fn assume_unit_quaternions(&mut self) {
        self.unit_quaternions = true;
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The node at a position of the arena.
    pub fn node(&self, index: usize) -> &Node {
        &self.nodes[index]
    }

    /// All nodes, operands before users.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = &Node> {
        self.nodes.iter()
    }

    /// The name of a let.
    pub fn name(&self, index: usize) -> Option<&str> {
        self.names.get(&(index as u32)).map(String::as_str)
    }

    fn intern(&mut self, node: Node) -> u32 {
        let (index, _) = self.nodes.insert_full(node);
        let index = u32::try_from(index).expect("the budget keeps a graph below 2^32 nodes");
        self.held.get(&index).copied().unwrap_or(index)
    }

    fn real(&mut self, node: Node) -> Real {
        Real(self.intern(node))
    }

    fn vector(&mut self, node: Node) -> Vector {
        Vector(self.intern(node))
    }

    fn truth(&mut self, node: Node) -> Truth {
        Truth(self.intern(node))
    }

    fn at(&self, real: Real) -> &Node {
        &self.nodes[real.index()]
    }

    fn vector_at(&self, vector: Vector) -> &Node {
        &self.nodes[vector.index()]
    }

    // ---- reals

    /// A number.
    pub fn constant(&mut self, value: Exact) -> Real {
        self.real(Node::Constant(value))
    }

    /// 0
    pub fn zero(&mut self) -> Real {
        self.constant(Exact::ZERO)
    }

    /// 1
    pub fn one(&mut self) -> Real {
        self.constant(Exact::ONE)
    }

    /// The number a node is, if it is one.
    pub fn value(&self, real: Real) -> Option<&Exact> {
        match self.at(real) {
            Node::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// Whether a node is the number 0.
    pub fn is_zero(&self, real: Real) -> bool {
        self.value(real).is_some_and(Exact::is_zero)
    }

    /// An entry of an argument.
    pub fn entry(&mut self, slot: Slot) -> Real {
        self.real(Node::Entry(slot))
    }

    /// A node as coefficient and rest: −2x is (−2, x).
    pub fn split(&self, real: Real) -> (Exact, Real) {
        match self.at(real) {
            Node::Sum(constant, terms) if terms.len() == 1 && constant.is_zero() => terms[0].clone(),
            _ => (Exact::ONE, real),
        }
    }

    /// constant + Σ coefficient · term
    pub fn sum(&mut self, constant: Exact, terms: Vec<(Exact, Real)>) -> Real {
        if !self.simplify {
            return self.real(Node::Sum(constant, terms.into()));
        }
        let mut constant = constant;
        let mut flat: Vec<(Exact, Real)> = Vec::new();
        for (coefficient, term) in terms {
            match self.at(term) {
                Node::Constant(value) => constant = &constant + &(&coefficient * value),
                Node::Sum(inner, terms) if terms.len() <= LONGEST_SUM => {
                    constant = &constant + &(&coefficient * inner);
                    flat.extend(terms.iter().map(|(c, t)| (&coefficient * c, *t)));
                }
                _ => flat.push((coefficient, term)),
            }
        }
        let flat = collect(flat);
        let flat = self.pin_components(flat);
        match (constant.is_zero(), flat.as_slice()) {
            (_, []) => self.constant(constant),
            (true, [(c, term)]) if c.is_one() => *term,
            _ => self.real(Node::Sum(constant, flat.into())),
        }
    }

    /// x + y
    pub fn add(&mut self, x: Real, y: Real) -> Real {
        self.sum(Exact::ZERO, vec![(Exact::ONE, x), (Exact::ONE, y)])
    }

    /// x − y
    pub fn sub(&mut self, x: Real, y: Real) -> Real {
        self.sum(Exact::ZERO, vec![(Exact::ONE, x), (-Exact::ONE, y)])
    }

    /// −x
    pub fn neg(&mut self, x: Real) -> Real {
        self.scaled(-Exact::ONE, x)
    }

    /// coefficient · x
    pub fn scaled(&mut self, coefficient: Exact, x: Real) -> Real {
        self.sum(Exact::ZERO, vec![(coefficient, x)])
    }

    /// Π factor^exponent
    pub fn product(&mut self, factors: &[(Real, i32)]) -> Real {
        if !self.simplify {
            return self.real(Node::Product(factors.into()));
        }
        let mut coefficient = Exact::ONE;
        let mut powers: BTreeMap<Real, i64> = BTreeMap::new();
        let mut pending: Vec<(Real, i32)> = factors.iter().rev().copied().collect();
        while let Some((factor, exponent)) = pending.pop() {
            if exponent == 0 {
                continue;
            }
            let (c, rest) = self.split(factor);
            let c = self.value(rest).map_or(c.clone(), |value| &c * value);
            if c.is_zero() && exponent < 0
                || c.bits().saturating_mul(exponent.unsigned_abs() as usize) > CONSTANT_BITS
            {
                // A division by a literal zero, or a power too long to hold: left to IEEE arithmetic.
                *powers.entry(factor).or_default() += i64::from(exponent);
                continue;
            }
            coefficient = &coefficient * &c.powi(exponent);
            match self.at(rest) {
                Node::Constant(_) => {}
                Node::Product(inner) if inner.len() <= LONGEST_PRODUCT => {
                    let inner = inner.clone();
                    for (f, e) in inner {
                        *powers.entry(f).or_default() += i64::from(e) * i64::from(exponent);
                    }
                }
                _ => *powers.entry(rest).or_default() += i64::from(exponent),
            }
        }
        if coefficient.is_zero() {
            return self.zero();
        }
        self.join_hyperbolic(&mut powers);
        let roots: Vec<Real> = powers.iter().filter(|(_, e)| e.abs() >= 2).map(|(f, _)| *f).collect();
        for root in roots {
            let radicand = match *self.at(root) {
                Node::Call(Function::Sqrt, ref arguments) => arguments[0],
                Node::Norm(v) => self.dot(v, v),
                _ => continue,
            };
            let exponent = powers.remove(&root).expect("collected above");
            if exponent % 2 != 0 {
                powers.insert(root, exponent % 2);
            }
            let (c, rest) = self.split(radicand);
            if !c.is_one()
                || !matches!(self.at(rest), Node::Dot(..) | Node::Entry(_) | Node::Let(_) | Node::Call(..))
            {
                // Only an atom is put in the place of its root; a product or sum would have to be taken apart.
                *powers.entry(root).or_default() += exponent - exponent % 2;
                continue;
            }
            *powers.entry(rest).or_default() += exponent / 2;
        }
        powers.retain(|_, e| *e != 0);
        let factors: Vec<(Real, i32)> = powers
            .into_iter()
            .map(|(f, e)| (f, e.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32))
            .collect();
        let product = match factors.as_slice() {
            [] => return self.constant(coefficient),
            [(factor, 1)] => *factor,
            _ => self.real(Node::Product(factors.into())),
        };
        self.scaled(coefficient, product)
    }

    /// sinh x / cosh x = tanh x: what derivatives of tanh are made of must not be ∞ · 0 where x is large.
    fn join_hyperbolic(&mut self, powers: &mut BTreeMap<Real, i64>) {
        let sines: Vec<(Real, i64)> = powers
            .iter()
            .filter(|(f, e)| **e > 0 && matches!(self.at(**f), Node::Call(Function::Sinh, _)))
            .map(|(f, e)| (*f, *e))
            .collect();
        for (sine, count) in sines {
            let Node::Call(_, arguments) = self.at(sine).clone() else { continue };
            let cosine = self.real(Node::Call(Function::Cosh, arguments.clone()));
            let below = powers.get(&cosine).map_or(0, |e| (-e).max(0));
            let joined = count.min(below);
            if joined == 0 {
                continue;
            }
            let tangent = self.real(Node::Call(Function::Tanh, arguments));
            for (factor, change) in [(sine, -joined), (cosine, joined), (tangent, joined)] {
                *powers.entry(factor).or_default() += change;
            }
        }
    }

    /// x y
    pub fn mul(&mut self, x: Real, y: Real) -> Real {
        self.product(&[(x, 1), (y, 1)])
    }

    /// x / y
    pub fn div(&mut self, x: Real, y: Real) -> Real {
        self.product(&[(x, 1), (y, -1)])
    }

    /// xⁿ
    pub fn powi(&mut self, x: Real, n: i32) -> Real {
        self.product(&[(x, n)])
    }

    /// A function of the table.
    pub fn call(&mut self, function: Function, arguments: &[Real]) -> Real {
        if self.simplify
            && let Some(simpler) = identities::apply(self, function, arguments)
        {
            return simpler;
        }
        self.real(Node::Call(function, arguments.into()))
    }

    /// if the condition holds x, else y
    pub fn select(&mut self, condition: Truth, x: Real, y: Real) -> Real {
        if self.simplify {
            match *self.truth_at(condition) {
                Node::Known(known) => return if known { x } else { y },
                _ if x == y => return x,
                Node::Not(inner) => return self.select(inner, y, x),
                _ => {}
            }
        }
        self.real(Node::Select(condition, x, y))
    }

    /// A named intermediate. Inputs and numbers stay what they are; of two names for one thing the first stays.
    pub fn let_real(&mut self, name: &str, value: Real) -> Real {
        let (coefficient, rest) = self.split(value);
        if !self.simplify
            || matches!(
                self.at(rest),
                Node::Constant(_) | Node::Entry(_) | Node::Let(_) | Node::Component(..)
            )
        {
            return value;
        }
        if self.holds_point(rest) {
            self.names.entry(rest.0).or_insert_with(|| name_of_multiple(name, &coefficient));
            return value;
        }
        let held = self.real(Node::Let(rest));
        self.held.insert(rest.0, held.0);
        self.names.entry(held.0).or_insert_with(|| name_of_multiple(name, &coefficient));
        self.scaled(coefficient, held)
    }

    /// Whether a sum has an entry of a point as a term. Such a sum is named but stays open, so that the difference of
    /// two of them becomes a difference of the points.
    fn holds_point(&self, sum: Real) -> bool {
        match self.at(sum) {
            Node::Sum(_, terms) => terms.iter().any(|(_, term)| match *self.at(*term) {
                Node::Component(v, _) => self.point(v).is_some(),
                _ => false,
            }),
            _ => false,
        }
    }

    /// Differences between entries of one axis of two points are pinned, as whole vectors are.
    fn pin_components(&mut self, terms: Vec<(Exact, Real)>) -> Vec<(Exact, Real)> {
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

    // ---- vectors

    /// Three consecutive entries of an argument.
    pub fn triple(&mut self, slot: Slot) -> Vector {
        self.vector(Node::Triple(slot))
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
            _ => self.real(Node::Component(v, axis)),
        }
    }

    /// The point a vector is: a position, or three entries of a parameter.
    fn point(&self, v: Vector) -> Option<Slot> {
        match *self.vector_at(v) {
            Node::Triple(slot) if matches!(self.signature.role(slot), None | Some(Role::Position)) => {
                Some(slot)
            }
            _ => None,
        }
    }

    /// A vector as coefficient and rest.
    pub fn split_vector(&self, v: Vector) -> (Exact, Vector) {
        match self.vector_at(v) {
            Node::VectorSum(terms) if terms.len() == 1 => terms[0].clone(),
            _ => (Exact::ONE, v),
        }
    }

    /// Σ coefficient · vector. Vectors that differ by a real factor are merged, differences of points pinned.
    pub fn vector_sum(&mut self, terms: Vec<(Exact, Vector)>) -> Vector {
        if !self.simplify {
            return self.vector(Node::VectorSum(terms.into()));
        }
        let mut flat: Vec<(Exact, Vector)> = Vec::new();
        for (coefficient, term) in terms {
            match self.vector_at(term) {
                Node::VectorSum(inner) if inner.len() <= LONGEST_SUM => {
                    flat.extend(inner.iter().map(|(c, v)| (&coefficient * c, *v)))
                }
                _ => flat.push((coefficient, term)),
            }
        }
        let flat = collect(flat);
        let flat = self.merge_scales(flat);
        let flat = self.pin(flat);
        match flat.as_slice() {
            [(c, v)] if c.is_one() => *v,
            _ => self.vector(Node::VectorSum(flat.into())),
        }
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

    fn pin(&mut self, terms: Vec<(Exact, Vector)>) -> Vec<(Exact, Vector)> {
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

    /// The difference of two positions, or two velocities, as its own node.
    pub fn difference(&mut self, first: Slot, second: Slot) -> Vector {
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
                // ω·(r × f) instead of f·(ω × r): the product of an arm and a force is wanted anyway.
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

    /// v/|v|
    pub fn normalize(&mut self, v: Vector) -> Vector {
        let norm = self.norm(v);
        let inverse = self.powi(norm, -1);
        self.scale(inverse, v)
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

    /// A parameter that is turned into the world is named after itself, so that a person recognises it.
    fn name_arm(&mut self, rotated: Vector, arm: Vector) {
        let Node::Rotate(quaternion, false, _) = *self.vector_at(rotated) else { return };
        let Node::Triple(slot) = *self.vector_at(arm) else { return };
        if self.signature.role(quaternion).is_none() {
            return;
        }
        if let Some(parameter) = self.signature.parameter(slot) {
            let number = if slot.offset == 0 { String::new() } else { format!("_{}", slot.offset / 3) };
            let name = format!("{}_world{number}", parameter.name);
            self.names.entry(rotated.0).or_insert(name);
        }
    }

    /// The product of stored unit quaternions as (x, y, z) and w; at least one of them.
    pub fn turn(&mut self, turn: &[(Slot, bool)]) -> (Vector, Real) {
        if let [(slot, inverse)] = *turn {
            let vector = self.triple(slot);
            let w = self.entry(Slot { offset: slot.offset + 3, ..slot });
            return (if inverse { self.vector_neg(vector) } else { vector }, w);
        }
        (self.vector(Node::TurnVector(turn.into())), self.real(Node::TurnReal(turn.into())))
    }

    /// if the condition holds u, else v
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

    /// A named intermediate.
    pub fn let_vector(&mut self, name: &str, value: Vector) -> Vector {
        let (coefficient, rest) = self.split_vector(value);
        let plain = matches!(self.vector_at(rest), Node::Triple(_) | Node::VectorLet(_) | Node::VectorSum(_))
            && !matches!(self.vector_at(rest), Node::VectorSum(terms) if terms.len() > 1);
        if !self.simplify || plain {
            return value;
        }
        if let Node::VectorSum(terms) = self.vector_at(rest)
            && terms.iter().any(|(_, v)| self.point(*v).is_some())
        {
            // A point in the world: open for the same reason as in `holds_point`.
            self.names.entry(rest.0).or_insert_with(|| name_of_multiple(name, &coefficient));
            return value;
        }
        let held = self.vector(Node::VectorLet(rest));
        self.held.insert(rest.0, held.0);
        self.names.entry(held.0).or_insert_with(|| name_of_multiple(name, &coefficient));
        self.vector_sum(vec![(coefficient, held)])
    }

    // ---- truths

    fn truth_at(&self, truth: Truth) -> &Node {
        &self.nodes[truth.index()]
    }

    /// A known truth.
    pub fn known(&mut self, value: bool) -> Truth {
        self.truth(Node::Known(value))
    }

    /// The truth a node is known to have.
    pub fn truth_value(&self, truth: Truth) -> Option<bool> {
        match self.truth_at(truth) {
            Node::Known(value) => Some(*value),
            _ => None,
        }
    }

    /// A comparison.
    pub fn compare(&mut self, comparison: Comparison, x: Real, y: Real) -> Truth {
        if self.simplify
            && let (Some(a), Some(b)) = (self.value(x), self.value(y))
        {
            let holds = match comparison {
                Comparison::Less => a < b,
                Comparison::LessEqual => a <= b,
                Comparison::Equal => a == b,
            };
            return self.known(holds);
        }
        self.truth(Node::Compare(comparison, x, y))
    }

    /// x < y
    pub fn less(&mut self, x: Real, y: Real) -> Truth {
        self.compare(Comparison::Less, x, y)
    }

    /// a ∧ b
    pub fn and(&mut self, a: Truth, b: Truth) -> Truth {
        if self.simplify {
            match (self.truth_value(a), self.truth_value(b)) {
                (Some(false), _) | (_, Some(false)) => return self.known(false),
                (Some(true), _) => return b,
                (_, Some(true)) => return a,
                _ if a == b => return a,
                _ => {}
            }
        }
        self.truth(Node::And(a, b))
    }

    /// a ∨ b
    pub fn or(&mut self, a: Truth, b: Truth) -> Truth {
        if self.simplify {
            match (self.truth_value(a), self.truth_value(b)) {
                (Some(true), _) | (_, Some(true)) => return self.known(true),
                (Some(false), _) => return b,
                (_, Some(false)) => return a,
                _ if a == b => return a,
                _ => {}
            }
        }
        self.truth(Node::Or(a, b))
    }

    /// ¬a
    pub fn not(&mut self, a: Truth) -> Truth {
        if self.simplify {
            match *self.truth_at(a) {
                Node::Known(value) => return self.known(!value),
                Node::Not(inner) => return inner,
                _ => {}
            }
        }
        self.truth(Node::Not(a))
    }
}

/// What to call x where the author's name is for a multiple of x.
fn name_of_multiple(name: &str, coefficient: &Exact) -> String {
    if coefficient.is_one() {
        name.to_owned()
    } else if (-coefficient).is_one() {
        format!("minus_{name}")
    } else {
        format!("{name}_part")
    }
}

/// A sum of more terms is a term itself where it is added to: accumulating n terms stays linear.
const LONGEST_SUM: usize = 32;

/// A product of more factors is a factor itself where it is multiplied: the derivative of a chain stays linear.
const LONGEST_PRODUCT: usize = 8;

/// Beyond this many bits a power of a number is left to the kernel.
const CONSTANT_BITS: usize = 4096;

/// Like terms added, zero terms dropped, in the order of their ids.
fn collect<T: Ord + Copy>(mut terms: Vec<(Exact, T)>) -> Vec<(Exact, T)> {
    terms.sort_by_key(|(_, id)| *id);
    let mut collected: Vec<(Exact, T)> = Vec::with_capacity(terms.len());
    for (c, id) in terms {
        match collected.last_mut() {
            Some((sum, last)) if *last == id => *sum = &*sum + &c,
            _ => collected.push((c, id)),
        }
    }
    collected.retain(|(c, _)| !c.is_zero());
    collected
}

/// Points of a sum, grouped into differences.
struct Paired {
    differences: Vec<(Exact, Slot, Slot)>,
    rest: Vec<(Exact, Slot)>,
}

/// Groups points of opposite coefficients into pinned differences, the greater slot first so that x_b − x_a and
/// x_a − x_b are one node. What does not cancel stays.
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
