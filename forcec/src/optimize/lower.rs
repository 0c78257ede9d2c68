//! From vectors to scalars: every node of the vector graph becomes reals, every block nine of them.
//!
//! In: [`Derived`] forces and the derivatives it forms on demand. Out: a [`Program`] on the canonical scalar graph.
//! A block is lowered from its normal form `s I + [k]× + Σ u vᵀ`, or from the dense product it came from, whichever
//! makes fewer new operations; an attempt that loses is rolled back. Rotations use one polynomial, v + 2w (u×v) +
//! 2u×(u×v) on the stored quaternion, as a matrix where it serves several arms.

use super::written;
use crate::bodies::Slot;
use crate::definition::{Definition, Law};
use crate::derive::lie::{Lie, Variable};
use crate::derive::matrix::Matrix;
use crate::derive::{Combination, Derived};
use crate::exact::{Exact, collect};
use crate::ops::Function;
use crate::outputs::{Array, Part};
use crate::scalar::{self, Id, Program};
use crate::vector::{Node, Real, Vector};
use rustc_hash::FxHashMap;
use smallvec::{SmallVec, smallvec};
use std::collections::{BTreeMap, BTreeSet};

type Dense = [[Id; 3]; 3];

/// Operations of a kernel as it is lowered: what takes more takes minutes, here and in the compiler that reads it.
pub const MOST_OPERATIONS: usize = 300_000;

/// Lowers forces and derivatives; the program knows its residual if that is of interest. `None` if it has more than
/// `most` operations. Where the function is given as it was written, its values are computed so, and what else is made of
/// them reads these.
pub fn lower(derived: Derived, residual: bool, most: usize, source: Option<&Definition>) -> Option<Program> {
    let signature = derived.lie.graph.signature.clone();
    let shared = shared_rotations(&derived);
    let mut lowering = Lowering {
        lie: derived.lie,
        scalar: scalar::Graph::default(),
        lowered: FxHashMap::default(),
        dense: FxHashMap::default(),
        journal: Vec::new(),
        ways: FxHashMap::default(),
        shared,
        most,
        full: false,
    };
    let written = source.map(|source| written::rows(&mut lowering.scalar, source));
    if let Some(written) = &written {
        lowering.stand_in(&derived.rows, written);
    }
    let returned = written.filter(|_| source.is_some_and(|source| matches!(source.law, Law::Force(_))));
    let [forces, impulses] = &derived.pieces;
    let mirrored = derived.symmetric.then_some(forces);
    // The same where poses move in steps.
    let stepped = derived.symmetric.then(|| lowering.lie.stepped(impulses));
    let lost =
        if residual { lowering.residual(&derived.rows, &derived.forces, derived.stated) } else { vec![] };
    let mut arrays = Vec::new();
    for &part in &derived.wanted {
        let entries = match part {
            Part::Value => derived.rows.iter().map(|(c, _)| lowering.real(*c)).collect(),
            Part::Rate => derived.rows.iter().map(|(_, rate)| lowering.real(*rate)).collect(),
            Part::Jacobian => lowering.jacobian(derived.rows.iter().map(|(c, _)| *c), &derived.pose),
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
            Part::Held => lowering.blocks(&derived.held, &derived.steps, None),
            Part::Impulse | Part::DfdxProduct | Part::DfdvProduct => lowering.forces(&derived.along[&part]),
            Part::List(_) | Part::Block(_) => unreachable!("entries are packed after optimising"),
        };
        arrays.push(Array::new(part, &signature, entries));
    }
    let full = lowering.is_full();
    let mut program = Program { signature, graph: lowering.scalar, arrays };
    let live = program.live();
    // A power takes few multiplications, however high.
    let size = |(id, node): (Id, &scalar::Node)| if live[id.index()] { node.operands().len() } else { 0 };
    if full || program.graph.iter().map(size).sum::<usize>() > most {
        return None;
    }
    lost.into_iter().filter(|id| live[id.index()]).for_each(|id| program.graph.set_residual(id));
    Some(program)
}

/// The stored quaternions that turn several arms.
fn shared_rotations(derived: &Derived) -> BTreeSet<Slot> {
    let graph = &derived.lie.graph;
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
            // Its derivatives turn three basis vectors.
            Node::TurnVector(turn) => turn.iter().for_each(|(slot, _)| *arms.entry(*slot).or_default() += 3),
            _ => {}
        }
        open.extend(node.operands());
    }
    arms.into_iter().filter(|(_, n)| *n > 1).map(|(slot, _)| slot).collect()
}

#[derive(Clone, Copy)]
pub(super) enum Lowered {
    Real(Id),
    Vector([Id; 3]),
}

enum Added {
    Lowered(u32),
    Dense(Vector, Variable),
}

pub(super) struct Lowering {
    pub(super) lie: Lie,
    pub(super) scalar: scalar::Graph,
    pub(super) lowered: FxHashMap<u32, Lowered>,
    dense: FxHashMap<(Vector, Variable), Dense>,
    /// What was added to `lowered` and to `dense`, in order, so that an attempt can be undone.
    journal: Vec<Added>,
    /// The way that was best for a derivative when it was first asked for.
    ways: FxHashMap<(Vector, Variable), Way>,
    shared: BTreeSet<Slot>,
    /// Operations there may be.
    most: usize,
    /// Whether something was left out because there is too much.
    full: bool,
}

impl Lowering {
    /// Whether there is so much that nothing more is lowered.
    fn is_full(&self) -> bool {
        let most = self.most.saturating_mul(2);
        self.full || self.scalar.len() > most || self.lie.graph.len() > most
    }

    pub(super) fn real(&mut self, x: Real) -> Id {
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
                open.extend(self.lie.graph.node(index as usize).operands());
            }
        }
        for index in missing {
            let lowered = self.lower_node(index);
            if let Some(name) = self.lie.graph.name(index as usize) {
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
        let node = self.lie.graph.node(index as usize).clone();
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

    /// An entry of an argument, or the number that stands for it.
    fn input(&mut self, slot: Slot) -> Id {
        match self.lie.graph.signature.folded(slot) {
            Some(value) => self.scalar.constant(value),
            None => self.scalar.input(slot),
        }
    }

    /// The pinned difference of two entries; from zero there is nothing to pin.
    fn difference(&mut self, first: Slot, second: Slot) -> Id {
        let zero = |slot: &Slot| self.lie.graph.signature.known(*slot).is_some_and(|value| value.is_zero());
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
                    // A power of a product is not the product of powers: each of these may leave the range.
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
            Node::Call(Function::Powf, arguments)
                if half_integer(&self.lie.graph, arguments[1]).is_some() =>
            {
                // x^(n + ½) = xⁿ √x, and for negative powers 1/(xⁿ √x).
                let twice = half_integer(&self.lie.graph, arguments[1]).expect("just seen");
                let x = self.id(arguments[0].0);
                let root = self.scalar.call(Function::Sqrt, &[x]);
                let whole = twice.unsigned_abs() / 2;
                let power = self.scalar.product(&[(x, whole), (root, 1)]);
                if twice < 0 { self.scalar.recip(power) } else { power }
            }
            Node::Call(function, arguments) => {
                let arguments: Vec<Id> = arguments.iter().map(|x| self.id(x.0)).collect();
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
            _ => unreachable!("{node:?} is no real"),
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

    /// v + 2w (u×v) + 2u×(u×v), or with −u for the inverse.
    fn rotate(&mut self, quaternion: Slot, inverse: bool, v: [Id; 3]) -> [Id; 3] {
        let [x, y, z, w] =
            [0, 1, 2, 3].map(|k| self.input(Slot { offset: quaternion.offset + k, ..quaternion }));
        let u = [x, y, z];
        let two = Exact::from(2);
        let double = u.map(|entry| self.scalar.scaled(two.clone(), entry));
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

    /// The matrix of the same polynomial.
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

    /// The rows of C, or E, become values that are known already.
    fn stand_in(&mut self, rows: &[(Real, Real)], values: &[Id]) {
        let mut vectors: BTreeMap<u32, [Option<Id>; 3]> = BTreeMap::new();
        for ((row, _), value) in rows.iter().zip(values) {
            let (c, rest) = self.lie.graph.split(*row);
            self.lowered.insert(row.0, Lowered::Real(*value));
            if !c.is_unit() {
                continue;
            }
            let value = self.scalar.scaled(c, *value);
            self.lowered.insert(rest.0, Lowered::Real(value));
            if let Node::Component(v, axis) = *self.lie.graph.node(rest.index()) {
                vectors.entry(v.0).or_default()[usize::from(axis)] = Some(value);
            }
        }
        for (v, entries) in vectors {
            if let [Some(x), Some(y), Some(z)] = entries {
                self.lowered.insert(v, Lowered::Vector([x, y, z]));
            }
        }
    }

    // ---- blocks

    /// The generalised forces.
    fn forces(&mut self, forces: &[(crate::bodies::Block, Combination<Vector>)]) -> Vec<Id> {
        let mut force = Vec::new();
        for (_, pieces) in forces {
            let parts: Vec<(Exact, [Id; 3])> =
                pieces.iter().map(|(c, v)| (c.clone(), self.vector(*v))).collect();
            force.extend(self.combined(&parts));
        }
        force
    }

    /// Rows of derivatives of reals.
    fn jacobian(
        &mut self,
        rows: impl Iterator<Item = Real>,
        columns: &[(crate::bodies::Block, Combination<Variable>)],
    ) -> Vec<Id> {
        let mut entries = Vec::new();
        for real in rows {
            for (_, moves) in columns {
                let mut parts = Vec::new();
                for (c, variable) in moves {
                    let row = self.lie.row(real, *variable);
                    parts.push((c.clone(), self.vector(row)));
                }
                entries.extend(self.combined(&parts));
            }
        }
        entries
    }

    /// Σ coefficient · vector
    fn combined(&mut self, parts: &[(Exact, [Id; 3])]) -> [Id; 3] {
        [0, 1, 2].map(|axis| {
            let terms = parts.iter().map(|(c, part)| (c.clone(), part[axis])).collect();
            self.scalar.sum(Exact::ZERO, terms)
        })
    }

    /// N rows of N entries from three-by-three blocks.
    fn blocks(
        &mut self,
        forces: &[(crate::bodies::Block, Combination<Vector>)],
        columns: &[(crate::bodies::Block, Combination<Variable>)],
        mirrored: Option<&BTreeMap<Vector, Variable>>,
    ) -> Vec<Id> {
        let mut entries = Vec::new();
        for (_, pieces) in forces {
            let mut rows: [Vec<Id>; 3] = Default::default();
            for (_, moves) in columns {
                let mut parts: Vec<(Exact, Dense)> = Vec::new();
                for (c, piece) in pieces {
                    for (d, variable) in moves {
                        parts.push((c * d, self.block(*piece, *variable, mirrored)));
                    }
                }
                for (i, row) in rows.iter_mut().enumerate() {
                    for j in 0..3 {
                        let terms = parts.iter().map(|(c, dense)| (c.clone(), dense[i][j])).collect();
                        row.push(self.scalar.sum(Exact::ZERO, terms));
                    }
                }
            }
            entries.extend(rows.into_iter().flatten());
        }
        entries
    }

    fn block(
        &mut self,
        piece: Vector,
        variable: Variable,
        mirrored: Option<&BTreeMap<Vector, Variable>>,
    ) -> Dense {
        let Some(pieces) = mirrored else { return self.best(piece, variable) };
        let Some(own) = pieces.get(&piece) else { return self.best(piece, variable) };
        let other = pieces.iter().find(|(_, v)| **v == variable).map(|(vector, _)| *vector);
        match other {
            Some(other) if *own > variable => transposed(self.best(other, *own)),
            Some(_) if *own == variable => {
                let dense = self.best(piece, variable);
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| dense[i.min(j)][i.max(j)]))
            }
            _ => self.best(piece, variable),
        }
    }

    /// D of a vector as nine scalars, by the cheapest of the ways there are.
    fn best(&mut self, vector: Vector, variable: Variable) -> Dense {
        if self.is_full() {
            return self.left_out();
        }
        if let Some(dense) = self.dense.get(&(vector, variable)) {
            return *dense;
        }
        let (coefficient, core) = self.lie.graph.split_vector(vector);
        let core = match *self.lie.graph.node(core.index()) {
            Node::VectorLet(inner) => inner,
            _ => core,
        };
        let dense = self.cheapest(core, variable);
        let dense = dense.map(|row| row.map(|id| self.scalar.scaled(coefficient.clone(), id)));
        self.dense.insert((vector, variable), dense);
        self.journal.push(Added::Dense(vector, variable));
        dense
    }

    /// Lowers D of a vector in each of the ways there are, on what exists already, and keeps the cheapest.
    fn cheapest(&mut self, vector: Vector, variable: Variable) -> Dense {
        if let Some(&way) = self.ways.get(&(vector, variable)) {
            return self.lower_block(vector, variable, way);
        }
        let (last, others) = self.ways_of(vector, variable).split_last().expect("there is a way");
        let mut best = (usize::MAX, *last);
        for &way in others {
            let (cost, _) = self.attempt(vector, variable, way, |_| false);
            if cost < best.0 {
                best = (cost, way);
            }
        }
        let (cost, dense) = self.attempt(vector, variable, *last, |cost| cost < best.0);
        let way = if cost < best.0 { *last } else { best.1 };
        self.ways.insert((vector, variable), way);
        if cost < best.0 { dense } else { self.lower_block(vector, variable, way) }
    }

    /// Lowers D of a vector in one way, and undoes it if its cost in operations is not to be kept.
    fn attempt(
        &mut self,
        vector: Vector,
        variable: Variable,
        way: Way,
        keep: impl Fn(usize) -> bool,
    ) -> (usize, Dense) {
        let (nodes, journal) = (self.scalar.len(), self.journal.len());
        let dense = self.lower_block(vector, variable, way);
        let cost = (nodes..self.scalar.len()).map(|i| self.scalar.cost(Id(i as u32)).total()).sum();
        if !keep(cost) {
            self.scalar.truncate(nodes);
            for added in self.journal.drain(journal..) {
                match added {
                    Added::Lowered(index) => drop(self.lowered.remove(&index)),
                    Added::Dense(vector, variable) => drop(self.dense.remove(&(vector, variable))),
                }
            }
        }
        (cost, dense)
    }

    /// What stands for a block of a kernel that is refused.
    fn left_out(&mut self) -> Dense {
        self.full = true;
        [[self.scalar.zero(); 3]; 3]
    }

    /// The ways to lower D of a vector that can differ.
    fn ways_of(&mut self, vector: Vector, variable: Variable) -> &'static [Way] {
        use Way::{Cross, Normal, Parts};
        let graph = &self.lie.graph;
        let is_cross = |v: Vector| matches!(graph.node(v.index()), Node::Cross(..));
        match *graph.node(vector.index()) {
            Node::VectorSum(ref terms) if terms.len() > 1 && terms.iter().any(|(_, v)| is_cross(*v)) => {
                if terms.len() > LONGEST_WHOLE {
                    &[Parts]
                } else {
                    &[Normal, Parts]
                }
            }
            Node::Cross(u, v) => {
                match [u, v].map(|side| self.lie.matrix(side, variable).is_zero(&self.lie.graph)) {
                    [true, true] => &[Normal],
                    [true, false] => &[Normal, Cross(true, false), Cross(false, false)],
                    [false, true] => &[Normal, Cross(false, true), Cross(false, false)],
                    [false, false] => &[
                        Normal,
                        Cross(true, false),
                        Cross(false, true),
                        Cross(true, true),
                        Cross(false, false),
                    ],
                }
            }
            _ => &[Normal],
        }
    }

    fn lower_block(&mut self, vector: Vector, variable: Variable, way: Way) -> Dense {
        match (way, self.lie.graph.node(vector.index()).clone()) {
            (Way::Parts, Node::VectorSum(terms)) => {
                let mut parts = Vec::new();
                let mut rest = Vec::new();
                for (c, term) in terms {
                    if matches!(self.lie.graph.node(term.index()), Node::Cross(..)) {
                        parts.push((c, self.best(term, variable)));
                    } else {
                        rest.push((c, term));
                    }
                }
                if !rest.is_empty() {
                    let rest = self.lie.graph.vector_sum(rest);
                    parts.push((Exact::ONE, self.normal(rest, variable)));
                }
                self.sum_of_blocks(&parts)
            }
            (Way::Cross(first, second), Node::Cross(u, v)) => {
                let mut parts = Vec::new();
                for (fixed, moved, sign, dense) in [(u, v, Exact::ONE, first), (v, u, -Exact::ONE, second)] {
                    let matrix = self.lie.matrix(moved, variable);
                    if matrix.is_zero(&self.lie.graph) {
                        continue;
                    }
                    let block = if dense {
                        let inner = self.normal(moved, variable);
                        let fixed = self.vector(fixed);
                        let columns = transposed(inner).map(|column| self.cross(fixed, column));
                        transposed(columns)
                    } else {
                        let matrix = matrix.cross_left(&mut self.lie.graph, fixed);
                        self.matrix(&matrix)
                    };
                    parts.push((sign, block));
                }
                self.sum_of_blocks(&parts)
            }
            _ => self.normal(vector, variable),
        }
    }

    fn sum_of_blocks(&mut self, parts: &[(Exact, Dense)]) -> Dense {
        [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let terms = parts.iter().map(|(c, dense)| (c.clone(), dense[i][j])).collect();
                self.scalar.sum(Exact::ZERO, terms)
            })
        })
    }

    fn normal(&mut self, vector: Vector, variable: Variable) -> Dense {
        let matrix = self.lie.matrix(vector, variable);
        self.matrix(&matrix)
    }

    /// s I + [k]× + Σ u vᵀ entry by entry. Where s holds −u·v the diagonal has two products fewer.
    fn matrix(&mut self, matrix: &Matrix) -> Dense {
        let matrix = &matrix.plain(&mut self.lie.graph);
        let mut identity = linear(&self.lie.graph, matrix.identity);
        let mut products: Vec<Dense> = Vec::new();
        let mut cancelled = Vec::new();
        for &(u, v) in &matrix.outer {
            if self.is_full() {
                return self.left_out();
            }
            let (left, right) = (self.vector(u), self.vector(v));
            products.push(left.map(|x| right.map(|y| self.scalar.mul(x, y))));
            let wanted = dot_terms(&mut self.lie.graph, u, v);
            let held = |(c, x): &(Exact, Real)| identity.contains(&(-c, *x));
            let cancels = !wanted.is_empty() && wanted.iter().all(held);
            if cancels {
                identity.retain(|(_, x)| wanted.iter().all(|(_, y)| x != y));
            }
            cancelled.push(cancels);
        }
        let rest = self.lie.graph.sum(Exact::ZERO, identity);
        let rest = self.real(rest);
        let skew = self.vector(matrix.skew);
        [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let mut terms = Vec::new();
                if i == j {
                    terms.push((Exact::ONE, rest));
                    for (product, cancelled) in products.iter().zip(&cancelled) {
                        if *cancelled {
                            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                            let pair = self.scalar.add(product[j][j], product[k][k]);
                            terms.push((-Exact::ONE, pair));
                        } else {
                            terms.push((Exact::ONE, product[i][i]));
                        }
                    }
                } else {
                    terms.extend(products.iter().map(|product| (Exact::ONE, product[i][j])));
                    let sign = if (i + 1) % 3 == j { -Exact::ONE } else { Exact::ONE };
                    terms.push((sign, skew[3 - i - j]));
                }
                self.scalar.sum(Exact::ZERO, terms)
            })
        })
    }
}

/// Longer sums are lowered term by term without an attempt at the whole.
const LONGEST_WHOLE: usize = 16;

#[derive(Clone, Copy)]
enum Way {
    /// From the normal form.
    Normal,
    /// A sum term by term, each by its own best way.
    Parts,
    /// A cross product, each side as a dense product or from its normal form.
    Cross(bool, bool),
}

fn transposed(dense: Dense) -> Dense {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| dense[j][i]))
}

/// Twice a number that lies halfway between whole ones and is not large.
fn half_integer(g: &crate::vector::Graph, x: Real) -> Option<i32> {
    let twice = g.value(x).map(|value| value + value)?.to_i64()?;
    (twice % 2 != 0 && twice.abs() <= 64).then_some(twice as i32)
}

/// A real as a linear combination of reals.
fn linear(g: &crate::vector::Graph, x: Real) -> Vec<(Exact, Real)> {
    match g.node(x.index()) {
        Node::Sum(constant, terms) if constant.is_zero() => terms.to_vec(),
        _ if g.is_zero(x) => vec![],
        _ => vec![(Exact::ONE, x)],
    }
}

/// u·v as the linear combination that the rules of the algebra would have made of it.
fn dot_terms(g: &mut crate::vector::Graph, u: Vector, v: Vector) -> Vec<(Exact, Real)> {
    // A vector as Σ coefficient · scale · vector.
    let parts = |g: &crate::vector::Graph, v: Vector| -> SmallVec<[(Exact, Option<Real>, Vector); 2]> {
        let part = |c: &Exact, v: Vector| match *g.node(v.index()) {
            Node::Scale(s, inner) => (c.clone(), Some(s), inner),
            _ => (c.clone(), None, v),
        };
        match g.node(v.index()) {
            Node::VectorSum(terms) => terms.iter().map(|(c, v)| part(c, *v)).collect(),
            _ => smallvec![part(&Exact::ONE, v)],
        }
    };
    let (left, right) = (parts(g, u), parts(g, v));
    let mut total = Vec::new();
    for (c, s, x) in &left {
        for (d, t, y) in &right {
            let mut dot = g.dot(*x, *y);
            if s.is_some() || t.is_some() {
                let one = g.one();
                let scale = g.mul(s.unwrap_or(one), t.unwrap_or(one));
                dot = g.mul(scale, dot);
            }
            let coefficient = c * d;
            total.extend(linear(g, dot).into_iter().map(|(e, term)| (&coefficient * &e, term)));
        }
    }
    collect(total)
}
