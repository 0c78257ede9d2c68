//! From vectors to scalars: every node of the vector graph becomes scalars, every block nine of them.
//!
//! In: [`Derived`] forces, and derivatives formed on demand. Out: a [`Program`] on the canonical scalar
//! graph. A block is lowered from its normal form `s I + [k]× + Σ u vᵀ`, or from the dense product it came
//! from, whichever adds fewer operations; the other attempt is rolled back. Rotations use one polynomial, v +
//! 2w (u×v) + 2u×(u×v) of the stored quaternion, and a matrix if the same quaternion rotates several arms.

mod blocks;
mod residual;
pub mod vocabulary;
mod written;

use blocks::Way;

use crate::derive::Derived;
use crate::derive::forward::{TangentDerivatives, Variable};
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::Slot;
use crate::model::outputs::{Array, Part};
use crate::scalar::{self, Id, Program};
use crate::vector::definition::{Definition, Law};
use crate::vector::{Node, Real, Vector};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};

type Dense = [[Id; 3]; 3];

/// The largest number of operations of a lowered kernel: a larger kernel takes minutes to lower and to
/// compile.
pub const MOST_OPERATIONS: usize = 500_000;

/// Lowers forces and derivatives; with `residual`, the program marks the scalars that lose digits. `None` if
/// the program has more than `most` operations. If `source` is given, the values of the function are computed
/// as the author wrote them, and everything derived from the values reads these.
pub fn lower(derived: Derived, residual: bool, most: usize, source: Option<&Definition>) -> Option<Program> {
    let signature = derived.tangent.graph.signature.clone();
    let shared = shared_rotations(&derived);
    let mut lowering = Lowering::new(derived.tangent, shared, most);
    let written = source.map(|source| written::rows(&mut lowering.scalar, source));
    if let Some(written) = &written {
        lowering.substitute(&derived.rows, written);
    }
    let returned = written.filter(|_| source.is_some_and(|source| matches!(source.law, Law::Force(_))));
    let [forces, impulses] = &derived.pieces;
    let mirrored = derived.symmetric.then_some(forces);
    // The corresponding map for poses that move in steps.
    let stepped = derived.symmetric.then(|| lowering.tangent.stepped(impulses));
    let lost =
        if residual { lowering.residual(&derived.rows, &derived.forces, derived.stated) } else { vec![] };
    let mut arrays = Vec::new();
    for &part in &derived.wanted {
        let entries = match part {
            Part::Value => derived.rows.iter().map(|(c, _)| lowering.real(*c)).collect(),
            Part::Rate => derived.rows.iter().map(|(_, rate)| lowering.real(*rate)).collect(),
            Part::Jacobian => lowering.jacobian(derived.rows.iter().map(|(c, _)| *c), &derived.pose),
            Part::Drift => derived.drifts.iter().map(|drift| lowering.real(*drift)).collect(),
            Part::Multiplier => derived.multipliers.iter().map(|(x, _)| lowering.real(*x)).collect(),
            Part::Force => match &returned {
                Some(returned) => returned.clone(),
                None => lowering.forces(&derived.forces),
            },
            Part::Dfdx => lowering.blocks(&derived.forces, &derived.pose, mirrored),
            Part::Dfdv => lowering.blocks(&derived.forces, &derived.velocity, None),
            Part::Matrix => lowering.blocks(&derived.impulses, &derived.steps, stepped.as_ref()),
            Part::MultiplierStep => {
                lowering.jacobian(derived.multipliers.iter().map(|(_, x)| *x), &derived.steps)
            }
            Part::Pull => lowering.forces(&derived.pull),
            Part::Geometric => lowering.blocks(&derived.pull, &derived.pose, None),
            Part::Held => {
                lowering.tangent.substitute(derived.substituted.clone());
                let blocks = lowering.blocks(&derived.held, &derived.steps, None);
                lowering.tangent.substitute(BTreeMap::new());
                blocks
            }
            Part::Impulse | Part::DfdxProduct | Part::DfdvProduct => lowering.forces(&derived.along[&part]),
            Part::List(_) | Part::Block(_) => unreachable!("entries are packed after optimising"),
        };
        arrays.push(Array::new(part, &signature, entries));
    }
    let full = lowering.is_full();
    let mut program = Program { signature, graph: lowering.scalar, arrays };
    let live = program.live();
    // A power takes few multiplications, even for a high exponent.
    let size = |(id, node): (Id, &scalar::Node)| if live[id.index()] { node.operands().len() } else { 0 };
    if full || program.graph.iter().map(size).sum::<usize>() > most {
        return None;
    }
    lost.into_iter().filter(|id| live[id.index()]).for_each(|id| program.graph.set_residual(id));
    Some(program)
}

/// The stored quaternions that rotate several arms.
fn shared_rotations(derived: &Derived) -> BTreeSet<Slot> {
    let graph = &derived.tangent.graph;
    let mut open: Vec<u32> =
        derived.forces.iter().flat_map(|(_, pieces)| pieces.iter().map(|(_, v)| v.0)).collect();
    let mut seen = vec![false; graph.len()];
    let mut arms: BTreeMap<Slot, usize> = BTreeMap::new();
    while let Some(index) = open.pop() {
        if std::mem::replace(&mut seen[index as usize], true) {
            continue;
        }
        let node = graph.node(index as usize);
        match node {
            Node::Rotate(quaternion, ..) => *arms.entry(*quaternion).or_default() += 1,
            // The derivatives of the product rotate three basis vectors.
            Node::TurnVector(turn) => turn.iter().for_each(|(slot, _)| *arms.entry(*slot).or_default() += 3),
            _ => {}
        }
        open.extend(node.operands());
    }
    arms.into_iter().filter(|(_, n)| *n > 1).map(|(slot, _)| slot).collect()
}

#[derive(Clone, Copy)]
pub(crate) enum Lowered {
    Real(Id),
    Vector([Id; 3]),
}

enum Added {
    Lowered(u32),
    Dense(Vector, Variable),
}

pub(crate) struct Lowering {
    pub(crate) tangent: TangentDerivatives,
    pub(crate) scalar: scalar::Graph,
    pub(crate) lowered: FxHashMap<u32, Lowered>,
    dense: FxHashMap<(Vector, Variable), Dense>,
    /// Keys added to `lowered` and to `dense`, in order, so that an attempt can be rolled back.
    journal: Vec<Added>,
    /// The best way to lower a derivative, chosen at its first request.
    ways: FxHashMap<(Vector, Variable), Way>,
    shared: BTreeSet<Slot>,
    /// The largest allowed number of operations.
    most: usize,
    /// Whether something was omitted because the kernel is too large.
    full: bool,
}

impl Lowering {
    fn new(tangent: TangentDerivatives, shared: BTreeSet<Slot>, most: usize) -> Lowering {
        Lowering {
            tangent,
            scalar: scalar::Graph::default(),
            lowered: FxHashMap::default(),
            dense: FxHashMap::default(),
            journal: Vec::new(),
            ways: FxHashMap::default(),
            shared,
            most,
            full: false,
        }
    }

    /// Whether the kernel is too large, so that nothing more is lowered.
    fn is_full(&self) -> bool {
        let most = self.most.saturating_mul(2);
        self.full || self.scalar.len() > most || self.tangent.graph.len() > most
    }

    pub(crate) fn real(&mut self, x: Real) -> Id {
        self.prepare(x.0);
        self.id(x.0)
    }

    fn vector(&mut self, v: Vector) -> [Id; 3] {
        self.prepare(v.0);
        self.entries(v)
    }

    fn id(&self, index: u32) -> Id {
        match self.lowered[&index] {
            Lowered::Real(id) => id,
            Lowered::Vector(_) => unreachable!("a real is one scalar"),
        }
    }

    fn entries(&self, v: Vector) -> [Id; 3] {
        match self.lowered[&v.0] {
            Lowered::Vector(entries) => entries,
            Lowered::Real(_) => unreachable!("a vector is three scalars"),
        }
    }

    fn prepare(&mut self, root: u32) {
        let mut open = vec![root];
        let mut missing = BTreeSet::new();
        while let Some(index) = open.pop() {
            if !self.lowered.contains_key(&index) && missing.insert(index) {
                open.extend(self.tangent.graph.node(index as usize).operands());
            }
        }
        for index in missing {
            let lowered = self.lower_node(index);
            if let Some(name) = self.tangent.graph.name(index as usize) {
                match lowered {
                    Lowered::Real(id) => self.scalar.set_name(id, name),
                    Lowered::Vector(entries) => {
                        for (id, axis) in entries.into_iter().zip(["x", "y", "z"]) {
                            self.scalar.set_name(id, &format!("{name}_{axis}"));
                        }
                    }
                }
            }
            self.lowered.insert(index, lowered);
            self.journal.push(Added::Lowered(index));
        }
    }

    fn lower_node(&mut self, index: u32) -> Lowered {
        let node = self.tangent.graph.node(index as usize).clone();
        match node {
            Node::Triple(slot) => {
                Lowered::Vector([0, 1, 2].map(|k| self.input(Slot { offset: slot.offset + k, ..slot })))
            }
            Node::Difference(first, second) => Lowered::Vector([0, 1, 2].map(|k| {
                let entry = |slot: Slot| Slot { offset: slot.offset + k, ..slot };
                self.difference(entry(first), entry(second))
            })),
            Node::VectorOffset(v, numbers) => {
                let entries = self.entries(v);
                Lowered::Vector([0, 1, 2].map(|k| self.scalar.offset(entries[k], numbers[k].clone())))
            }
            Node::VectorSum(terms) => {
                let parts: Vec<(Exact, [Id; 3])> =
                    terms.iter().map(|(c, v)| (c.clone(), self.entries(*v))).collect();
                Lowered::Vector([0, 1, 2].map(|k| {
                    let terms = parts.iter().map(|(c, part)| (c.clone(), part[k])).collect();
                    self.scalar.sum(Exact::ZERO, terms)
                }))
            }
            Node::Scale(s, v) => {
                let s = self.id(s.0);
                Lowered::Vector(self.entries(v).map(|x| self.scalar.mul(s, x)))
            }
            Node::Cross(u, v) => {
                let (u, v) = (self.entries(u), self.entries(v));
                Lowered::Vector(self.cross(u, v))
            }
            Node::Rotate(quaternion, inverse, v) => {
                let v = self.entries(v);
                Lowered::Vector(self.rotate(quaternion, inverse, v))
            }
            Node::TurnVector(turn) => {
                let [x, y, z, _] = self.turn(&turn);
                Lowered::Vector([x, y, z])
            }
            Node::Pack(entries) => Lowered::Vector(entries.map(|x| self.id(x.0))),
            Node::VectorSelect(condition, u, v) => {
                let condition = self.id(condition.0);
                let (u, v) = (self.entries(u), self.entries(v));
                Lowered::Vector([0, 1, 2].map(|k| self.scalar.select(condition, u[k], v[k])))
            }
            Node::VectorLet(v) => Lowered::Vector(self.entries(v)),
            _ => Lowered::Real(self.lower_real(&node)),
        }
    }

    /// An argument entry, or the number that replaces the entry.
    fn input(&mut self, slot: Slot) -> Id {
        match self.tangent.graph.signature.folded(slot) {
            Some(value) => self.scalar.constant(value),
            None => self.scalar.input(slot),
        }
    }

    /// The pinned difference of two entries; if an entry is zero, no difference is pinned.
    fn difference(&mut self, first: Slot, second: Slot) -> Id {
        let zero =
            |slot: &Slot| self.tangent.graph.signature.known(*slot).is_some_and(|value| value.is_zero());
        if [first, second].iter().any(zero) {
            let (first, second) = (self.input(first), self.input(second));
            return self.scalar.sub(first, second);
        }
        self.scalar.difference(first, second)
    }

    fn lower_real(&mut self, node: &Node) -> Id {
        match node {
            Node::Constant(value) => self.scalar.constant(value.clone()),
            Node::Entry(slot) => self.input(*slot),
            Node::Sum(constant, terms) => {
                let terms = terms.iter().map(|(c, x)| (c.clone(), self.id(x.0))).collect();
                self.scalar.sum(constant.clone(), terms)
            }
            Node::Product(factors) => {
                let mut powers = Vec::with_capacity(factors.len());
                for &(factor, exponent) in factors {
                    let id = self.id(factor.0);
                    // A power of a product is not expanded into a product of powers: a single power may leave
                    // the range.
                    let id = if exponent.unsigned_abs() > 1 { self.scalar.held(id) } else { id };
                    let base = if exponent < 0 { self.scalar.recip(id) } else { id };
                    powers.push((base, exponent.unsigned_abs()));
                }
                self.scalar.product(&powers)
            }
            Node::Dot(u, v) => {
                let (u, v) = (self.entries(*u), self.entries(*v));
                self.dot(u, v)
            }
            Node::Component(v, axis) => self.entries(*v)[*axis as usize],
            Node::Norm(v) => {
                let v = self.entries(*v);
                let square = self.dot(v, v);
                self.scalar.call(Function::Sqrt, &[square])
            }
            Node::TurnReal(turn) => self.turn(turn)[3],
            Node::Call(function, arguments) => {
                if *function == Function::Powf
                    && let Some(twice) = half_integer(&self.tangent.graph, arguments[1])
                {
                    // x^(n + ½) = xⁿ √x, and for negative powers 1/(xⁿ √x).
                    let x = self.id(arguments[0].0);
                    let root = self.scalar.call(Function::Sqrt, &[x]);
                    let power = self.scalar.product(&[(x, twice.unsigned_abs() / 2), (root, 1)]);
                    return if twice < 0 { self.scalar.recip(power) } else { power };
                }
                let arguments: Vec<Id> = arguments.iter().map(|x| self.id(x.0)).collect();
                if *function == Function::HypotSlope {
                    let length = self.scalar.call(Function::Hypot, &arguments);
                    let inverse = self.scalar.recip(length);
                    return self.scalar.product(&[(arguments[0], 1), (inverse, 1)]);
                }
                self.scalar.call(*function, &arguments)
            }
            Node::Select(condition, x, y) => {
                let (condition, x, y) = (self.id(condition.0), self.id(x.0), self.id(y.0));
                self.scalar.select(condition, x, y)
            }
            Node::Offset(x, number) => self.scalar.offset(self.id(x.0), number.clone()),
            Node::Let(x) => self.id(x.0),
            Node::Known(value) => self.scalar.known(*value),
            Node::Compare(comparison, x, y) => {
                let (x, y) = (self.id(x.0), self.id(y.0));
                self.scalar.compare(*comparison, x, y)
            }
            Node::And(a, b) => {
                let (a, b) = (self.id(a.0), self.id(b.0));
                self.scalar.and(a, b)
            }
            Node::Or(a, b) => {
                let (a, b) = (self.id(a.0), self.id(b.0));
                self.scalar.or(a, b)
            }
            Node::Not(a) => {
                let a = self.id(a.0);
                self.scalar.not(a)
            }
            _ => unreachable!("{node:?} is not a real"),
        }
    }

    fn dot(&mut self, u: [Id; 3], v: [Id; 3]) -> Id {
        let terms = (0..3).map(|k| (Exact::ONE, self.scalar.mul(u[k], v[k]))).collect();
        self.scalar.sum(Exact::ZERO, terms)
    }

    fn cross(&mut self, u: [Id; 3], v: [Id; 3]) -> [Id; 3] {
        [(1, 2), (2, 0), (0, 1)].map(|(j, k)| {
            let (first, second) = (self.scalar.mul(u[j], v[k]), self.scalar.mul(u[k], v[j]));
            self.scalar.sub(first, second)
        })
    }

    /// The product of stored quaternions: (u, w)(v, s) = (w v + s u + u×v, w s − u·v).
    fn turn(&mut self, turn: &[(Slot, bool)]) -> [Id; 4] {
        let mut product: Option<([Id; 3], Id)> = None;
        for (slot, inverse) in turn {
            let [x, y, z, s] = [0, 1, 2, 3].map(|k| self.input(Slot { offset: slot.offset + k, ..*slot }));
            let v = if *inverse { [x, y, z].map(|entry| self.scalar.neg(entry)) } else { [x, y, z] };
            product = Some(match product {
                None => (v, s),
                Some((u, w)) => {
                    let across = self.cross(u, v);
                    let vector = [0, 1, 2].map(|k| {
                        let (first, second) = (self.scalar.mul(w, v[k]), self.scalar.mul(s, u[k]));
                        self.scalar
                            .sum(Exact::ZERO, [first, second, across[k]].map(|id| (Exact::ONE, id)).into())
                    });
                    let (straight, along) = (self.scalar.mul(w, s), self.dot(u, v));
                    (vector, self.scalar.sub(straight, along))
                }
            });
        }
        let ([x, y, z], w) = product.expect("a product has factors");
        [x, y, z, w]
    }

    /// The parts u, 2u and w of a stored quaternion (u, w).
    fn quaternion(&mut self, slot: Slot) -> ([Id; 3], [Id; 3], Id) {
        let [x, y, z, w] = [0, 1, 2, 3].map(|k| self.input(Slot { offset: slot.offset + k, ..slot }));
        let u = [x, y, z];
        (u, u.map(|entry| self.scalar.scaled(Exact::from(2), entry)), w)
    }

    /// v + 2w (u×v) + 2u×(u×v), or with −u for the inverse.
    fn rotate(&mut self, quaternion: Slot, inverse: bool, v: [Id; 3]) -> [Id; 3] {
        let (u, double, w) = self.quaternion(quaternion);
        if !self.shared.contains(&quaternion) {
            let turned = if inverse { self.cross(v, double) } else { self.cross(double, v) };
            let across = if inverse { self.cross(turned, u) } else { self.cross(u, turned) };
            return [0, 1, 2].map(|k| {
                let along = self.scalar.mul(w, turned[k]);
                self.scalar.sum(Exact::ZERO, [v[k], along, across[k]].map(|id| (Exact::ONE, id)).into())
            });
        }
        let matrix = self.rotation_matrix(u, double, w);
        [0, 1, 2].map(|i| {
            let row = [0, 1, 2].map(|j| if inverse { matrix[j][i] } else { matrix[i][j] });
            self.dot(row, v)
        })
    }

    /// The matrix of the rotation polynomial.
    fn rotation_matrix(&mut self, u: [Id; 3], double: [Id; 3], w: Id) -> Dense {
        let one = Exact::ONE;
        let square = [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.scalar.mul(u[i.min(j)], double[i.max(j)])));
        let turn = double.map(|d| self.scalar.mul(w, d));
        let mut matrix = square;
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let rest = vec![(-Exact::ONE, square[j][j]), (-Exact::ONE, square[k][k])];
            matrix[i][i] = self.scalar.sum(one.clone(), rest);
            matrix[i][j] = self.scalar.sub(square[i][j], turn[k]);
            matrix[j][i] = self.scalar.add(square[i][j], turn[k]);
        }
        matrix
    }

    /// Replaces the rows of C, or E, by values that are already lowered.
    fn substitute(&mut self, rows: &[(Real, Real)], values: &[Id]) {
        let mut vectors: BTreeMap<u32, [Option<Id>; 3]> = BTreeMap::new();
        for ((row, _), value) in rows.iter().zip(values) {
            let (c, rest) = self.tangent.graph.split(*row);
            self.lowered.insert(row.0, Lowered::Real(*value));
            if !c.is_unit() {
                continue;
            }
            let value = self.scalar.scaled(c, *value);
            self.lowered.insert(rest.0, Lowered::Real(value));
            if let Node::Component(v, axis) = *self.tangent.graph.node(rest.index()) {
                vectors.entry(v.0).or_default()[usize::from(axis)] = Some(value);
            }
        }
        for (v, entries) in vectors {
            if let [Some(x), Some(y), Some(z)] = entries {
                self.lowered.insert(v, Lowered::Vector([x, y, z]));
            }
        }
    }
}

/// Twice a number that is halfway between two integers and not large.
fn half_integer(g: &crate::vector::Graph, x: Real) -> Option<i32> {
    let twice = g.value(x).map(|value| value + value)?.to_i64()?;
    (twice % 2 != 0 && twice.abs() <= 64).then_some(twice as i32)
}
