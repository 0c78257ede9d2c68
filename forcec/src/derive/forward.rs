//! Derivatives along tangent coordinates, memoised per node and variable.
//!
//! In: a node of the vector graph and a variable, which is three tangent coordinates. Out: for a real, the
//! row of its derivative as a vector; for a vector, a [`Matrix`]. A variable is a stored triple that moves by
//! δ, a pinned difference as a whole, or an orientation that turns by δθ: D_θ (q·r) = −[q·r]×.

use crate::derive::block::Matrix;
use crate::derive::partials::partial;
use crate::derive::reverse::gradient;
use crate::derive::{Combination, block};
use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::model::bodies::{Block, Role, Slot};
use crate::vector::{Graph, Node, Real, Vector};
use indexmap::IndexSet;
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Three tangent coordinates that move together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Variable {
    /// A position, velocity or angular velocity.
    Triple(Slot),
    /// A pinned difference of two triples.
    Difference(Slot, Slot),
    /// An orientation.
    Rotation(Slot),
    /// Pose and velocity moved together by a time step: an index into [`TangentDerivatives::steps`].
    Step(u16),
}

/// The variables that a time step h moves along w: the pose by h w, the velocity by w.
pub type StepMove = [Option<Variable>; 2];

/// The derivative of one node.
#[derive(Clone, Debug)]
pub enum Derivative {
    /// The row of a real.
    Row(Vector),
    /// The matrix of a vector.
    Matrix(Rc<Matrix>),
    /// Truths have no derivative.
    None,
}

/// A graph with a cache of derivatives.
pub struct TangentDerivatives {
    /// The graph; derivatives are nodes of the graph.
    pub graph: Graph,
    /// Differences that are variables; they do not change when one of their points is a variable.
    pub difference_variables: BTreeSet<(Slot, Slot)>,
    memo: FxHashMap<(u32, Variable), Derivative>,
    /// Rows that were formed backward.
    rows: FxHashMap<Real, BTreeMap<Variable, Vector>>,
    /// Every variable.
    variables: Vec<Variable>,
    /// The number of nodes that rows may still be formed backward through; then rows are formed forward.
    backward: usize,
    /// The pairs of pose and velocity variables that a time step moves together.
    pub steps: Vec<StepMove>,
    /// The step h, if an output needs it.
    pub step: Option<Real>,
    /// Maps an input to an earlier node whose derivatives the input has; see [`TangentDerivatives::substitute`].
    pub(super) substituted: BTreeMap<u32, u32>,
}

/// The limit on nodes that rows are formed backward through: a chain of n factors passes each factor n times.
const BACKWARD_STEPS: usize = 20_000;

impl TangentDerivatives {
    /// Creates an empty cache.
    pub fn new(graph: Graph, difference_variables: BTreeSet<(Slot, Slot)>) -> TangentDerivatives {
        let backward = if graph.formulation.backward { BACKWARD_STEPS } else { 0 };
        let signature = &graph.signature;
        let mut variables: Vec<Variable> = difference_variables
            .iter()
            .map(|(first, second)| Variable::Difference(*first, *second))
            .collect();
        for block in signature.pose_blocks().into_iter().chain(signature.velocity_blocks()) {
            variables
                .extend(signature.body_slot(block.body, block.role).map(|slot| variable(slot, block.role)));
        }
        variables.sort();
        let (memo, rows) = (FxHashMap::default(), FxHashMap::default());
        let (steps, substituted) = (Vec::new(), BTreeMap::new());
        TangentDerivatives {
            graph,
            difference_variables,
            memo,
            rows,
            variables,
            backward,
            steps,
            step: None,
            substituted,
        }
    }

    /// From now on, gives inputs the derivatives of earlier nodes, and other inputs their own.
    pub fn substitute(&mut self, substituted: BTreeMap<u32, u32>) {
        self.substituted = substituted;
        self.memo.clear();
        self.rows.clear();
    }

    /// The derivative of a real, as a row.
    pub fn row(&mut self, real: Real, variable: Variable) -> Vector {
        self.prepare(real.0, variable);
        self.row_of(real, variable)
    }

    /// The derivative of a vector.
    pub fn matrix(&mut self, vector: Vector, variable: Variable) -> Rc<Matrix> {
        self.prepare(vector.0, variable);
        self.matrix_of(vector, variable)
    }

    fn row_of(&self, real: Real, variable: Variable) -> Vector {
        match &self.memo[&(real.0, variable)] {
            Derivative::Row(row) => *row,
            _ => unreachable!("a real has a row"),
        }
    }

    fn matrix_of(&self, vector: Vector, variable: Variable) -> Rc<Matrix> {
        match &self.memo[&(vector.0, variable)] {
            Derivative::Matrix(matrix) => Rc::clone(matrix),
            _ => unreachable!("a vector has a matrix"),
        }
    }

    /// Differentiates a node and its operands, operands first, without recursion.
    fn prepare(&mut self, root: u32, variable: Variable) {
        let mut open = vec![root];
        let mut missing = BTreeSet::new();
        while let Some(index) = open.pop() {
            if self.memo.contains_key(&(index, variable)) || !missing.insert(index) {
                continue;
            }
            open.extend(self.graph.node(index as usize).operands());
            open.extend(self.substituted.get(&index));
        }
        for index in missing {
            let derivative = self.derive(index, variable);
            self.memo.insert((index, variable), derivative);
        }
    }

    fn derive(&mut self, index: u32, variable: Variable) -> Derivative {
        if let Some(other) = self.substituted.get(&index) {
            return self.memo[&(*other, variable)].clone();
        }
        let node = self.graph.node(index as usize).clone();
        if let Variable::Step(step) = variable {
            match node {
                Node::Entry(_) | Node::TurnReal(_) => {
                    let row =
                        self.along_step(step, |tangent, moved| tangent.derive_real(index, &node, moved));
                    return Derivative::Row(row);
                }
                Node::Triple(_) | Node::Difference(..) | Node::TurnVector(_) => {
                    let [pose, velocity] = self.steps[step as usize];
                    let mut parts = Vec::new();
                    if let (Some(pose), Some(h)) = (pose, self.step) {
                        let matrix = self.derive_vector(index, &node, pose);
                        parts.push(matrix.scale(&mut self.graph, h));
                    }
                    parts.extend(velocity.map(|velocity| self.derive_vector(index, &node, velocity)));
                    let parts: Vec<(Exact, &Matrix)> = parts.iter().map(|m| (Exact::ONE, m)).collect();
                    return Derivative::Matrix(Rc::new(Matrix::sum(&mut self.graph, &parts)));
                }
                _ => {}
            }
        }
        match node {
            Node::Known(_) | Node::Compare(..) | Node::And(..) | Node::Or(..) | Node::Not(_) => {
                Derivative::None
            }
            Node::Constant(_)
            | Node::Entry(_)
            | Node::Sum(..)
            | Node::Product(_)
            | Node::Dot(..)
            | Node::Component(..)
            | Node::Norm(_)
            | Node::TurnReal(_)
            | Node::Call(..)
            | Node::Select(..)
            | Node::Offset(..)
            | Node::Let(_) => Derivative::Row(self.derive_real(index, &node, variable)),
            _ => Derivative::Matrix(Rc::new(self.derive_vector(index, &node, variable))),
        }
    }

    /// A row along a time step, from the rows along pose and velocity.
    fn along_step(
        &mut self,
        step: u16,
        mut row: impl FnMut(&mut TangentDerivatives, Variable) -> Vector,
    ) -> Vector {
        let [pose, velocity] = self.steps[step as usize];
        let mut rows = Vec::new();
        if let (Some(pose), Some(h)) = (pose, self.step) {
            let row = row(self, pose);
            rows.push((Exact::ONE, self.graph.scale(h, row)));
        }
        rows.extend(velocity.map(|velocity| (Exact::ONE, row(self, velocity))));
        self.graph.vector_sum(rows)
    }

    fn derive_real(&mut self, index: u32, node: &Node, variable: Variable) -> Vector {
        match node {
            Node::Entry(slot) => self.entry(*slot, variable),
            Node::Sum(_, terms) => {
                let rows = terms.iter().map(|(c, x)| (c.clone(), self.row_of(*x, variable))).collect();
                self.graph.vector_sum(rows)
            }
            Node::Product(factors) => {
                let mut rows = Vec::new();
                for (k, &(factor, exponent)) in factors.iter().enumerate() {
                    let row = self.row_of(factor, variable);
                    if !self.graph.is_zero_vector(row) {
                        let partial = partial_of_product(&mut self.graph, factors, k);
                        rows.push((Exact::from(i64::from(exponent)), self.graph.scale(partial, row)));
                    }
                }
                self.graph.vector_sum(rows)
            }
            Node::Dot(u, v) => {
                let (du, dv) = (self.matrix_of(*u, variable), self.matrix_of(*v, variable));
                let first = dv.row_times(&mut self.graph, *u);
                let second = du.row_times(&mut self.graph, *v);
                self.graph.vector_add(first, second)
            }
            Node::Component(v, axis) => {
                let matrix = self.matrix_of(*v, variable);
                let basis = self.graph.basis(*axis);
                matrix.row_times(&mut self.graph, basis)
            }
            Node::Norm(v) => {
                let matrix = self.matrix_of(*v, variable);
                if matrix.is_zero(&self.graph) {
                    return self.graph.zero_vector();
                }
                let unit = self.graph.normalize(*v);
                matrix.row_times(&mut self.graph, unit)
            }
            Node::TurnReal(turn) => {
                let mut rows = Vec::new();
                for turned in RotatedArm::places(turn, variable) {
                    let (u, _) = self.graph.turn(turn);
                    rows.push((-&turned.coefficient, turned.unrotate(&mut self.graph, u)));
                }
                self.graph.vector_sum(rows)
            }
            Node::Call(function @ (Function::Min | Function::Max), arguments) => {
                let (x, y) = (arguments[0], arguments[1]);
                let (dx, dy) = (self.row_of(x, variable), self.row_of(y, variable));
                let below =
                    if *function == Function::Min { self.graph.less(x, y) } else { self.graph.less(y, x) };
                self.graph.vector_select(below, dx, dy)
            }
            Node::Call(function, arguments) => {
                let mut rows = Vec::new();
                for (k, argument) in arguments.iter().enumerate() {
                    let row = self.row_of(*argument, variable);
                    if !self.graph.is_zero_vector(row) {
                        let partial = partial(&mut self.graph, *function, arguments, Real(index), k);
                        rows.push((Exact::ONE, self.graph.scale(partial, row)));
                    }
                }
                self.graph.vector_sum(rows)
            }
            Node::Select(condition, x, y) => {
                let (dx, dy) = (self.row_of(*x, variable), self.row_of(*y, variable));
                self.graph.vector_select(*condition, dx, dy)
            }
            Node::Let(x) | Node::Offset(x, _) => self.row_of(*x, variable),
            _ => self.graph.zero_vector(),
        }
    }

    /// The derivative of a stored real: D_θ (u, w) = (½ (w δ + δ × u), −½ u·δ) for a quaternion (u, w).
    fn entry(&mut self, slot: Slot, variable: Variable) -> Vector {
        let g = &mut self.graph;
        let base = Slot { offset: 0, ..slot };
        match variable {
            Variable::Rotation(quaternion) if base == quaternion => {
                let half = Exact::ratio(1, 2);
                let imaginary = g.triple(base);
                if slot.offset == 3 {
                    return g.vector_sum(vec![(-half, imaginary)]);
                }
                let w = g.entry(Slot { offset: 3, ..slot });
                let basis = g.basis(slot.offset as u8);
                let along = g.scale(w, basis);
                let across = g.cross(imaginary, basis);
                g.vector_sum(vec![(half.clone(), along), (half, across)])
            }
            Variable::Triple(moved) if base == moved => g.basis(slot.offset as u8),
            _ => g.zero_vector(),
        }
    }

    fn derive_vector(&mut self, index: u32, node: &Node, variable: Variable) -> Matrix {
        match node {
            Node::Triple(slot) => match variable {
                Variable::Triple(moved) if moved == *slot => self.unit(Exact::ONE),
                Variable::Rotation(quaternion) if quaternion == *slot => {
                    let half = Exact::ratio(1, 2);
                    let w = self.graph.entry(Slot { offset: 3, ..*slot });
                    let imaginary = self.graph.triple(*slot);
                    let skew = self.graph.vector_sum(vec![(-half.clone(), imaginary)]);
                    {
                        let identity = self.graph.scaled(half, w);
                        Matrix::skew(&mut self.graph, identity, skew)
                    }
                }
                _ => Matrix::zero(&mut self.graph),
            },
            Node::Difference(first, second) => match variable {
                Variable::Difference(p, q) if (p, q) == (*first, *second) => self.unit(Exact::ONE),
                Variable::Triple(_) if self.difference_variables.contains(&(*first, *second)) => {
                    Matrix::zero(&mut self.graph)
                }
                Variable::Triple(moved) if moved == *first => self.unit(Exact::ONE),
                Variable::Triple(moved) if moved == *second => self.unit(-Exact::ONE),
                _ => Matrix::zero(&mut self.graph),
            },
            Node::VectorSum(terms) => {
                let parts: Vec<(Exact, Rc<Matrix>)> =
                    terms.iter().map(|(c, v)| (c.clone(), self.matrix_of(*v, variable))).collect();
                let parts: Vec<(Exact, &Matrix)> = parts.iter().map(|(c, m)| (c.clone(), &**m)).collect();
                Matrix::sum(&mut self.graph, &parts)
            }
            Node::Scale(s, v) => {
                let row = self.factor_row(*s, variable);
                let matrix = self.matrix_of(*v, variable);
                let g = &mut self.graph;
                if let Node::Product(factors) = g.node(s.index())
                    && let [(norm, -1)] = **factors
                    && *g.node(norm.index()) == Node::Norm(*v)
                {
                    // n = d/|d|: dn = (dd − n (nᵀ dd))/|d|
                    let unit = g.scale(*s, *v);
                    debug_assert!(unit.0 == index || !matches!(g.node(unit.index()), Node::Scale(..)));
                    let along = matrix.row_times(g, unit);
                    let along = Matrix::outer(g, vec![(unit, along)]);
                    let across = Matrix::sum(g, &[(Exact::ONE, &matrix), (-Exact::ONE, &along)]);
                    return across.scale(g, *s);
                }
                let scaled = matrix.scale(g, *s);
                let turned = Matrix::outer(g, vec![(*v, row)]);
                Matrix::sum(g, &[(Exact::ONE, &scaled), (Exact::ONE, &turned)])
            }
            Node::Cross(u, v) => {
                let (du, dv) = (self.matrix_of(*u, variable), self.matrix_of(*v, variable));
                let g = &mut self.graph;
                let first = dv.cross_left(g, *u);
                let second = du.cross_left(g, *v);
                Matrix::sum(g, &[(Exact::ONE, &first), (-Exact::ONE, &second)])
            }
            Node::Rotate(quaternion, inverse, v) => {
                let inner = self.matrix_of(*v, variable);
                let inner = inner.rotate_left(&mut self.graph, *quaternion, *inverse);
                let turns = Variable::Rotation(*quaternion);
                let step = match variable {
                    Variable::Step(step) if self.steps[step as usize][0] == Some(turns) => self.step,
                    _ if variable == turns => None,
                    _ => return inner,
                };
                let g = &mut self.graph;
                let turned = if *inverse {
                    // D (Rᵀ v) = Rᵀ [v]×
                    let zero = g.zero();
                    Matrix::skew(g, zero, *v).rotate_left(g, *quaternion, true)
                } else {
                    let rotated = g.rotate(*quaternion, false, *v);
                    let (zero, opposite) = (g.zero(), g.vector_neg(rotated));
                    Matrix::skew(g, zero, opposite)
                };
                let turned = step.map_or_else(|| turned.clone(), |h| turned.scale(g, h));
                Matrix::sum(g, &[(Exact::ONE, &turned), (Exact::ONE, &inner)])
            }
            Node::TurnVector(turn) => {
                let mut parts = Vec::new();
                for turned in RotatedArm::places(turn, variable) {
                    let (u, w) = self.graph.turn(turn);
                    parts.push((turned.coefficient.clone(), turned.matrix(&mut self.graph, u, w)));
                }
                let parts: Vec<(Exact, &Matrix)> = parts.iter().map(|(c, m)| (c.clone(), m)).collect();
                Matrix::sum(&mut self.graph, &parts)
            }
            Node::Pack(entries) => {
                let rows = entries.map(|x| self.row_of(x, variable));
                self.stacked(rows)
            }
            Node::VectorSelect(condition, u, v) => {
                let (du, dv) = (self.matrix_of(*u, variable), self.matrix_of(*v, variable));
                let g = &mut self.graph;
                if du.is_simple() && dv.is_simple() {
                    let identity = g.select(*condition, du.identity, dv.identity);
                    let skew = g.vector_select(*condition, du.skew, dv.skew);
                    return Matrix::skew(g, identity, skew);
                }
                let rows = [0, 1, 2].map(|axis| {
                    let basis = g.basis(axis);
                    let (x, y) = (du.row_times(g, basis), dv.row_times(g, basis));
                    g.vector_select(*condition, x, y)
                });
                self.stacked(rows)
            }
            Node::VectorLet(v) | Node::VectorOffset(v, _) => (*self.matrix_of(*v, variable)).clone(),
            _ => unreachable!("{node:?} is not a vector"),
        }
    }

    /// The row of a scalar factor of a vector, formed backward if that is enabled.
    fn factor_row(&mut self, factor: Real, variable: Variable) -> Vector {
        if !self.rows.contains_key(&factor) {
            if self.backward == 0 {
                return self.row_of(factor, variable);
            }
            let (one, variables) = (self.graph.one(), self.variables.clone());
            let rows = gradient(self, &[(factor, one)], &[], &variables);
            self.rows.insert(factor, rows);
        }
        let row = |tangent: &mut TangentDerivatives, variable: Variable| {
            let row = tangent.rows[&factor].get(&variable).copied();
            row.unwrap_or_else(|| tangent.graph.zero_vector())
        };
        match variable {
            Variable::Step(step) => self.along_step(step, row),
            _ => row(self, variable),
        }
    }

    /// Counts one node of backward propagation.
    pub(super) fn step(&mut self) {
        self.backward = self.backward.saturating_sub(1);
    }

    fn unit(&mut self, sign: Exact) -> Matrix {
        let s = self.graph.constant(sign);
        Matrix::identity(&mut self.graph, s)
    }

    fn stacked(&mut self, rows: [Vector; 3]) -> Matrix {
        let g = &mut self.graph;
        let outer = rows.iter().enumerate().map(|(axis, row)| (g.basis(axis as u8), *row)).collect();
        Matrix::outer(g, outer)
    }

    /// Combines pose and velocity of each block into variables w with δX = h w and δV = w.
    pub fn step_with(
        &mut self,
        step: Option<Real>,
        pose: &[(Block, Combination<Variable>)],
        velocity: &[(Block, Combination<Variable>)],
    ) -> Vec<(Block, Combination<Variable>)> {
        let Some(h) = step else { return Vec::new() };
        self.step = Some(h);
        let mut known: IndexSet<StepMove> = IndexSet::new();
        let mut together = Vec::new();
        for ((block, poses), (_, velocities)) in pose.iter().zip(velocity) {
            let same = poses.len() == velocities.len()
                && poses.iter().zip(velocities).all(|((c, _), (d, _))| c == d);
            let moves: Vec<(Exact, StepMove)> = if same {
                let pairs = poses.iter().zip(velocities);
                pairs.map(|((c, x), (_, v))| (c.clone(), [Some(*x), Some(*v)])).collect()
            } else {
                let poses = poses.iter().map(|(c, x)| (c.clone(), [Some(*x), None]));
                poses.chain(velocities.iter().map(|(c, v)| (c.clone(), [None, Some(*v)]))).collect()
            };
            let mut variable =
                |(c, moves): (Exact, StepMove)| (c, Variable::Step(known.insert_full(moves).0 as u16));
            together.push((*block, moves.into_iter().map(&mut variable).collect()));
        }
        self.steps = known.into_iter().collect();
        together
    }

    /// The step variables of the poses that these forces act on; other variables are left out.
    pub fn stepped(&self, pieces: &BTreeMap<Vector, Variable>) -> BTreeMap<Vector, Variable> {
        let step = |pose: &Variable| self.steps.iter().position(|moves| moves[0] == Some(*pose));
        let stepped = pieces.iter().filter_map(|(v, pose)| Some((*v, Variable::Step(step(pose)? as u16))));
        stepped.collect()
    }

    /// The variable that moves a body's block directly.
    pub fn variable(&self, body: u16, role: Role) -> Variable {
        let slot = self.graph.signature.body_slot(body, role).expect("a block names a stored field");
        variable(slot, role)
    }
}

fn variable(slot: Slot, role: Role) -> Variable {
    match role {
        Role::Orientation => Variable::Rotation(slot),
        _ => Variable::Triple(slot),
    }
}

/// A factor of a product of quaternions q that turns by δθ, s = R δθ: D q = c (0, s) q; with `right`, c q (0,
/// s).
pub(super) struct RotatedArm {
    /// c, ½ or −½
    pub(super) coefficient: Exact,
    /// The factors of R, left to right.
    rotations: Vec<(Slot, bool)>,
    right: bool,
}

impl RotatedArm {
    /// Every factor of the product that turns with the variable. A factor f changes by ½ δθ f, its inverse by
    /// −½ f⁻¹ δθ; δθ is moved to the nearer end of the product.
    pub(super) fn places(turn: &[(Slot, bool)], variable: Variable) -> Vec<RotatedArm> {
        let mut places = Vec::new();
        for (k, &(slot, inverse)) in turn.iter().enumerate() {
            if variable == Variable::Rotation(slot) {
                let coefficient = Exact::ratio(if inverse { -1 } else { 1 }, 2);
                let (before, after) = turn.split_at(k + usize::from(inverse));
                let right = after.len() < before.len();
                let rotations = if right {
                    after.iter().rev().map(|(slot, inverse)| (*slot, !inverse)).collect()
                } else {
                    before.to_vec()
                };
                places.push(RotatedArm { coefficient, rotations, right });
            }
        }
        places
    }

    /// R v
    pub(super) fn rotate(&self, g: &mut Graph, v: Vector) -> Vector {
        self.rotations.iter().rev().fold(v, |v, (slot, inverse)| g.rotate(*slot, *inverse, v))
    }

    /// R⁻¹ v
    pub(super) fn unrotate(&self, g: &mut Graph, v: Vector) -> Vector {
        self.rotations.iter().fold(v, |v, (slot, inverse)| g.rotate(*slot, !inverse, v))
    }

    /// The vector part of (0, s) (u, w), or of (u, w) (0, s): w s ± s × u.
    pub(super) fn vector_part(&self, g: &mut Graph, s: Vector, u: Vector, w: Real) -> Vector {
        let along = g.scale(w, s);
        let across = if self.right { g.cross(u, s) } else { g.cross(s, u) };
        g.vector_add(along, across)
    }

    /// The transpose of [`RotatedArm::vector_part`] in s: w p ± u × p.
    pub(super) fn transposed(&self, g: &mut Graph, p: Vector, u: Vector, w: Real) -> Vector {
        let along = g.scale(w, p);
        let across = if self.right { g.cross(p, u) } else { g.cross(u, p) };
        g.vector_add(along, across)
    }

    /// The derivative of the vector part, without the coefficient: (w I ∓ [u]×) R.
    fn matrix(&self, g: &mut Graph, u: Vector, w: Real) -> Matrix {
        let skew = if self.right { u } else { g.vector_neg(u) };
        if self.rotations.is_empty() {
            return Matrix::skew(g, w, skew);
        }
        let turned = block::RotatedBlock { identity: w, skew, rotations: self.rotations.clone() };
        Matrix { turned: Some(turned), ..Matrix::zero(g) }
    }
}

/// ∂(Π fᵉ)/∂f_k without the factor e_k; never divides by f_k.
pub(super) fn partial_of_product(g: &mut Graph, factors: &[(Real, i32)], k: usize) -> Real {
    let mut rest = factors.to_vec();
    rest[k].1 -= 1;
    rest.retain(|(_, e)| *e != 0);
    g.product(&rest)
}
