//! The vocabulary of a function: names for the scalars that its values and derivatives are made of.
//!
//! In: derived forces. Out: scalars, each with a name that a reader of the source understands. They are the
//! author's values, entries of rotation matrices, derivatives of the author's values and of the rows of C, and
//! simple combinations of these. The scheduler finds them again by value, whatever the optimiser made of the
//! formulas. Of two names for one value, the first is used.

use crate::derive::Derived;
use crate::lower::{Lowered, Lowering, shared_rotations};
use crate::math::exact::Exact;
use crate::model::bodies::{Role, Signature, Slot};
use crate::names::values::{ValueName, difference_name, entry_name, flat, whole_name};
use crate::scalar::{Graph, Id};
use crate::vector::{Node, Real, Vector};
use std::ops::Range;

const AXES: [&str; 3] = ["x", "y", "z"];

/// A function with more nodes has names for the author's values alone: nobody reads its kernel.
const LONGEST_FUNCTION: usize = 1_000;

/// The largest number of first derivatives that get names.
const MOST_FIRST: usize = 4_000;

/// The largest number of second derivatives that get names.
const MOST_SECOND: usize = 20_000;

/// Named scalars.
pub struct Vocabulary {
    pub(crate) signature: Signature,
    pub(crate) graph: Graph,
    /// The names, the most telling first.
    pub(crate) words: Vec<(ValueName, Id)>,
}

/// The vocabulary of derived forces; empty for a kernel with more than `most` operations.
pub fn vocabulary(derived: Derived, most: usize) -> Vocabulary {
    let signature = derived.tangent.graph.signature.clone();
    let shared = shared_rotations(&derived);
    let mut words = Words { lowering: Lowering::new(derived.tangent, shared, most), words: Vec::new() };
    words.named();
    words.rotations();
    if derived.stated <= LONGEST_FUNCTION {
        words.derivatives(&derived.rows, &derived.multipliers, &derived.pose, &derived.drift_nodes);
        // The derivatives of the forces contribute the vectors that they are written with.
        for blocks in [&derived.pose, &derived.velocity] {
            words.lowering.blocks(&derived.forces, blocks, None);
        }
        words.described();
    }
    let Words { lowering, words } = words;
    let words = if lowering.is_full() { Vec::new() } else { words };
    Vocabulary { signature, graph: lowering.scalar, words }
}

struct Words {
    lowering: Lowering,
    words: Vec<(ValueName, Id)>,
}

type Moves = [(crate::model::bodies::Block, crate::derive::Combination<crate::derive::forward::Variable>)];

impl Words {
    fn add(&mut self, name: ValueName, id: Id) {
        self.words.extend(name.short().map(|name| (name, id)));
    }

    fn add_lowered(&mut self, name: &ValueName, index: usize) {
        match self.lowering.lowered[&(index as u32)] {
            Lowered::Real(id) => self.add(name.clone(), id),
            Lowered::Vector(entries) => {
                for (id, axis) in entries.into_iter().zip(AXES) {
                    self.add(name.and(&format!("_{axis}")), id);
                }
            }
        }
    }

    /// The values that the author named, those that differentiation named, and what helpers return.
    fn named(&mut self) {
        let count = self.lowering.tangent.graph.len();
        let names: [fn(&crate::vector::Graph, usize) -> Option<&str>; 2] =
            [crate::vector::Graph::name, crate::vector::Graph::helper];
        for (names, index) in names.iter().flat_map(|names| (0..count).map(move |index| (names, index))) {
            let graph = &self.lowering.tangent.graph;
            let Some(name) = names(graph, index).filter(|_| graph.node(index).is_value()) else { continue };
            let name = ValueName::source(name);
            self.lowering.prepare(index as u32);
            self.add_lowered(&name, index);
        }
    }

    /// The matrix of each orientation: `a_r01`.
    fn rotations(&mut self) {
        let signature = self.lowering.tangent.graph.signature.clone();
        for (body, argument) in signature.bodies.iter().enumerate() {
            let Some(slot) = signature.body_slot(body as u16, Role::Orientation) else { continue };
            let (u, double, w) = self.lowering.quaternion(slot);
            let matrix = self.lowering.rotation_matrix(u, double, w);
            for (i, j) in (0..9).map(|entry| (entry / 3, entry % 3)) {
                self.add(ValueName::plain(format!("{}_r{i}{j}", argument.name)), matrix[i][j]);
            }
        }
    }

    /// Derivatives of the rows, of λ and of the author's values along the coordinates: `c_0_by_a_rx`; second
    /// derivatives of the rows and of the author's reals: `length_by_a_x_b_y`. Drifts are not differentiated: the
    /// table of functions ends with the second derivatives of C.
    fn derivatives(
        &mut self,
        rows: &[(Real, Real)],
        multipliers: &[(Real, Real)],
        pose: &Moves,
        drifts: &Range<usize>,
    ) {
        let coordinates = self.lowering.tangent.graph.signature.coordinate_names();
        let coordinates: Vec<String> = coordinates.iter().map(|name| flat(name)).collect();
        let number = |k: usize| if rows.len() == 1 { String::new() } else { format!("_{k}") };
        let mut values: Vec<(ValueName, Real, bool)> = Vec::new();
        let rows = if multipliers.is_empty() { &[] } else { rows };
        for (k, (c, rate)) in rows.iter().enumerate() {
            values.push((ValueName::plain(format!("c{}", number(k))), *c, true));
            values.push((ValueName::plain(format!("c{}_dot", number(k))), *rate, false));
        }
        for (k, (multiplier, _)) in multipliers.iter().enumerate() {
            values.push((ValueName::plain(format!("lambda{}", number(k))), *multiplier, false));
        }
        for index in (0..self.lowering.tangent.graph.len()).filter(|index| !drifts.contains(index)) {
            let graph = &mut self.lowering.tangent.graph;
            let Some(name) = graph.name(index).map(ValueName::source) else { continue };
            match graph.node(index) {
                Node::Let(_) => values.push((name, Real(index as u32), true)),
                Node::VectorLet(_) => {
                    for (axis, letter) in AXES.iter().enumerate() {
                        let entry = graph.component(Vector(index as u32), axis as u8);
                        values.push((name.and(&format!("_{letter}")), entry, false));
                    }
                }
                _ => {}
            }
        }
        if values.len() * coordinates.len() > MOST_FIRST {
            return;
        }
        for (name, value, _) in &values {
            let entries = self.lowering.jacobian(std::iter::once(*value), pose);
            for (entry, coordinate) in entries.into_iter().zip(&coordinates) {
                self.add(name.and(&format!("_by_{coordinate}")), entry);
            }
        }
        let twice: Vec<&(ValueName, Real, bool)> = values.iter().filter(|(.., twice)| *twice).collect();
        if twice.len() * coordinates.len().pow(2) > MOST_SECOND {
            return;
        }
        for (name, value, _) in twice {
            for (b, (_, moves)) in pose.iter().enumerate() {
                let row: Vec<(Exact, Vector)> = moves
                    .iter()
                    .map(|(c, variable)| (c.clone(), self.lowering.tangent.row(*value, *variable)))
                    .collect();
                let forces = [(pose[b].0, row)];
                let entries = self.lowering.blocks(&forces, pose, None);
                for (place, entry) in entries.into_iter().enumerate() {
                    let (i, j) = (3 * b + place / coordinates.len(), place % coordinates.len());
                    let name = name.and(&format!("_by_{}_{}", coordinates[i], coordinates[j]));
                    self.add(name, entry);
                }
            }
        }
    }

    /// What is simply made of named values: `na_cross_gap_x`, `inv_length`.
    fn described(&mut self) {
        let count = self.lowering.tangent.graph.len();
        let mut names: Vec<Option<ValueName>> = Vec::with_capacity(count);
        for index in 0..count {
            let graph = &self.lowering.tangent.graph;
            let name = match graph.name(index) {
                Some(name) => Some(ValueName::source(name)),
                None if graph.helper(index).is_some() => graph.helper(index).map(ValueName::source),
                None => description(graph, graph.node(index), &names).and_then(ValueName::short),
            };
            let unnamed = graph.name(index).is_none() && graph.node(index).is_value();
            if let Some(name) = name.as_ref().filter(|_| unnamed) {
                self.lowering.prepare(index as u32);
                self.add_lowered(name, index);
            }
            if let Node::Rotate(slot, _, v) = *self.lowering.tangent.graph.node(index)
                && let Some(name) = names[v.index()].as_ref()
            {
                self.turned(slot, v, &name.and("_turn"));
            }
            names.push(name);
        }
    }

    /// 2 u × v, which the rotation of v by a quaternion (u, w) is made of.
    fn turned(&mut self, quaternion: Slot, v: Vector, name: &ValueName) {
        let (_, double, _) = self.lowering.quaternion(quaternion);
        let v = self.lowering.vector(v);
        for (entry, axis) in self.lowering.cross(double, v).into_iter().zip(AXES) {
            self.add(name.and(&format!("_{axis}")), entry);
            let half = self.lowering.scalar.scaled(Exact::ratio(1, 2), entry);
            self.add(name.after("half_").and(&format!("_{axis}")), half);
        }
    }
}

/// A name for a node from the names of its operands.
fn description(graph: &crate::vector::Graph, node: &Node, names: &[Option<ValueName>]) -> Option<ValueName> {
    let real = |x: &Real| names[x.index()].as_ref();
    let vector = |v: &Vector| names[v.index()].as_ref();
    let signature = &graph.signature;
    let plain = |text: String| Some(ValueName::plain(text));
    let turn = |factors: &[(Slot, bool)]| {
        let factor = |(slot, inverse): &(Slot, bool)| {
            let name = match signature.bodies.get(slot.argument as usize) {
                Some(body) => body.name.clone(),
                None => whole_name(signature, *slot),
            };
            if *inverse { format!("inv_{name}") } else { name }
        };
        ValueName::plain(factors.iter().map(factor).collect::<Vec<_>>().join("_"))
    };
    match node {
        Node::Entry(slot) => plain(entry_name(signature, *slot)),
        Node::Triple(slot) => plain(whole_name(signature, *slot)),
        Node::Difference(first, second) => plain(difference_name(signature, *first, *second)?),
        Node::Let(x) => real(x).cloned(),
        Node::VectorLet(v) => vector(v).cloned(),
        Node::Component(v, axis) => Some(vector(v)?.and(&format!("_{}", AXES[usize::from(*axis)]))),
        Node::Norm(v) => Some(vector(v)?.and("_norm")),
        Node::Dot(u, v) if u == v => Some(vector(u)?.and("_norm_sq")),
        Node::Dot(u, v) => Some(vector(u)?.join("_dot_", vector(v)?)),
        Node::Cross(u, v) => Some(vector(u)?.join("_cross_", vector(v)?)),
        Node::Scale(s, v) => Some(real(s)?.join("_", vector(v)?)),
        Node::Rotate(_, false, v) => Some(vector(v)?.and("_world")),
        Node::Rotate(slot, true, v) => {
            let body = signature.bodies.get(slot.argument as usize)?;
            Some(vector(v)?.and(&format!("_in_{}", body.name)))
        }
        Node::TurnReal(factors) => Some(turn(factors).and("_w")),
        Node::TurnVector(factors) => Some(turn(factors)),
        Node::Call(function, arguments) => match &**arguments {
            [x] => real(x)?.call(*function),
            _ => None,
        },
        Node::Product(factors) => match &**factors {
            [(x, exponent)] => Some(real(x)?.power(i64::from(*exponent))),
            [(x, 1), (y, -1)] | [(y, -1), (x, 1)] => Some(real(x)?.join("_per_", real(y)?)),
            [(x, m), (y, n)] => Some(real(x)?.power(i64::from(*m)).join("_", &real(y)?.power(i64::from(*n)))),
            _ => None,
        },
        Node::Sum(zero, terms) if zero.is_zero() => {
            let terms: Option<Vec<_>> = terms.iter().map(|(c, x)| Some((c, real(x)?))).collect();
            combination(&terms?)
        }
        Node::VectorSum(terms) => {
            let terms: Option<Vec<_>> = terms.iter().map(|(c, v)| Some((c, vector(v)?))).collect();
            combination(&terms?)
        }
        _ => None,
    }
}

/// The name of a multiple, or of a sum or difference of two values.
fn combination(terms: &[(&Exact, &ValueName)]) -> Option<ValueName> {
    let is = |c: &Exact, value: i64| *c == Exact::from(value);
    match *terms {
        [(c, x)] if is(c, -1) => Some(x.opposite()),
        [(c, x)] if is(c, 2) => Some(x.after("two_")),
        [(c, x)] if *c == Exact::ratio(1, 2) => Some(x.after("half_")),
        [(c, x), (d, y)] if is(c, 1) && is(d, 1) => Some(x.join("_plus_", y)),
        [(c, x), (d, y)] if is(c, 1) && is(d, -1) => Some(x.join("_minus_", y)),
        [(c, x), (d, y)] if is(c, -1) && is(d, 1) => Some(y.join("_minus_", x)),
        _ => None,
    }
}
