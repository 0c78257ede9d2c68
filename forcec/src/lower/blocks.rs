//! Blocks of derivatives: three by three scalars for a vector and a variable.
//!
//! In: forces, and the variables of differentiation. Out: the entries of results on the scalar graph. Each
//! block is lowered in the cheapest available way; other attempts are rolled back.

use crate::derive::Combination;
use crate::derive::block::Matrix;
use crate::derive::forward::Variable;
use crate::lower::{Added, Dense, Lowering};
use crate::math::exact::{Exact, collect};
use crate::scalar::Id;
use crate::vector::{Node, Real, Vector};
use smallvec::{SmallVec, smallvec};
use std::collections::BTreeMap;

impl Lowering {
    /// Lowers the generalised forces.
    pub(crate) fn forces(
        &mut self,
        forces: &[(crate::model::bodies::Block, Combination<Vector>)],
    ) -> Vec<Id> {
        let mut force = Vec::new();
        for (_, pieces) in forces {
            let parts: Vec<(Exact, [Id; 3])> =
                pieces.iter().map(|(c, v)| (c.clone(), self.vector(*v))).collect();
            force.extend(self.combined(&parts));
        }
        force
    }

    /// Lowers the derivatives of reals, row by row.
    pub(crate) fn jacobian(
        &mut self,
        rows: impl Iterator<Item = Real>,
        columns: &[(crate::model::bodies::Block, Combination<Variable>)],
    ) -> Vec<Id> {
        let mut entries = Vec::new();
        for real in rows {
            for (_, moves) in columns {
                let mut parts = Vec::new();
                for (c, variable) in moves {
                    let row = self.tangent.row(real, *variable);
                    parts.push((c.clone(), self.vector(row)));
                }
                entries.extend(self.combined(&parts));
            }
        }
        entries
    }

    /// Σ coefficient · vector
    pub(crate) fn combined(&mut self, parts: &[(Exact, [Id; 3])]) -> [Id; 3] {
        [0, 1, 2].map(|axis| {
            let terms = parts.iter().map(|(c, part)| (c.clone(), part[axis])).collect();
            self.scalar.sum(Exact::ZERO, terms)
        })
    }

    /// Lowers N rows of N entries from three-by-three blocks.
    pub(crate) fn blocks(
        &mut self,
        forces: &[(crate::model::bodies::Block, Combination<Vector>)],
        columns: &[(crate::model::bodies::Block, Combination<Variable>)],
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

    pub(crate) fn block(
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

    /// D of a vector as nine scalars, lowered in the cheapest available way.
    pub(crate) fn best(&mut self, vector: Vector, variable: Variable) -> Dense {
        if self.is_full() {
            return self.left_out();
        }
        if let Some(dense) = self.dense.get(&(vector, variable)) {
            return *dense;
        }
        let (coefficient, core) = self.tangent.graph.split_vector(vector);
        let core = match *self.tangent.graph.node(core.index()) {
            Node::VectorLet(inner) => inner,
            _ => core,
        };
        let dense = self.cheapest(core, variable);
        let dense = dense.map(|row| row.map(|id| self.scalar.scaled(coefficient.clone(), id)));
        self.dense.insert((vector, variable), dense);
        self.journal.push(Added::Dense(vector, variable));
        dense
    }

    /// Lowers D of a vector in every available way, given the existing nodes, and keeps the cheapest.
    pub(crate) fn cheapest(&mut self, vector: Vector, variable: Variable) -> Dense {
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

    /// Lowers D of a vector in one way, and rolls it back unless `keep` accepts its cost in operations.
    pub(crate) fn attempt(
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

    /// A placeholder block for a kernel that is rejected as too large.
    pub(crate) fn left_out(&mut self) -> Dense {
        self.full = true;
        [[self.scalar.zero(); 3]; 3]
    }

    /// The ways to lower D of a vector that may give different results.
    pub(crate) fn ways_of(&mut self, vector: Vector, variable: Variable) -> &'static [Way] {
        use Way::{Cross, Normal, Parts};
        let graph = &self.tangent.graph;
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
                match [u, v].map(|side| self.tangent.matrix(side, variable).is_zero(&self.tangent.graph)) {
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

    pub(crate) fn lower_block(&mut self, vector: Vector, variable: Variable, way: Way) -> Dense {
        match (way, self.tangent.graph.node(vector.index()).clone()) {
            (Way::Parts, Node::VectorSum(terms)) => {
                let mut parts = Vec::new();
                let mut rest = Vec::new();
                for (c, term) in terms {
                    if matches!(self.tangent.graph.node(term.index()), Node::Cross(..)) {
                        parts.push((c, self.best(term, variable)));
                    } else {
                        rest.push((c, term));
                    }
                }
                if !rest.is_empty() {
                    let rest = self.tangent.graph.vector_sum(rest);
                    parts.push((Exact::ONE, self.normal(rest, variable)));
                }
                self.sum_of_blocks(&parts)
            }
            (Way::Cross(first, second), Node::Cross(u, v)) => {
                let mut parts = Vec::new();
                for (fixed, moved, sign, dense) in [(u, v, Exact::ONE, first), (v, u, -Exact::ONE, second)] {
                    let matrix = self.tangent.matrix(moved, variable);
                    if matrix.is_zero(&self.tangent.graph) {
                        continue;
                    }
                    let block = if dense {
                        let inner = self.normal(moved, variable);
                        let fixed = self.vector(fixed);
                        let columns = transposed(inner).map(|column| self.cross(fixed, column));
                        transposed(columns)
                    } else {
                        let matrix = matrix.cross_left(&mut self.tangent.graph, fixed);
                        self.matrix(&matrix)
                    };
                    parts.push((sign, block));
                }
                self.sum_of_blocks(&parts)
            }
            _ => self.normal(vector, variable),
        }
    }

    pub(crate) fn sum_of_blocks(&mut self, parts: &[(Exact, Dense)]) -> Dense {
        [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let terms = parts.iter().map(|(c, dense)| (c.clone(), dense[i][j])).collect();
                self.scalar.sum(Exact::ZERO, terms)
            })
        })
    }

    pub(crate) fn normal(&mut self, vector: Vector, variable: Variable) -> Dense {
        let matrix = self.tangent.matrix(vector, variable);
        self.matrix(&matrix)
    }

    /// s I + [k]× + Σ u vᵀ entry by entry. If s contains the term −u·v, the diagonal has two products fewer.
    pub(crate) fn matrix(&mut self, matrix: &Matrix) -> Dense {
        let matrix = &matrix.plain(&mut self.tangent.graph);
        let mut identity = linear(&self.tangent.graph, matrix.identity);
        let mut products: Vec<Dense> = Vec::new();
        let mut cancelled = Vec::new();
        for &(u, v) in &matrix.outer {
            if self.is_full() {
                return self.left_out();
            }
            let (left, right) = (self.vector(u), self.vector(v));
            products.push(left.map(|x| right.map(|y| self.scalar.mul(x, y))));
            let wanted = dot_terms(&mut self.tangent.graph, u, v);
            let held = |(c, x): &(Exact, Real)| identity.contains(&(-c, *x));
            let cancels = !wanted.is_empty() && wanted.iter().all(held);
            if cancels {
                identity.retain(|(_, x)| wanted.iter().all(|(_, y)| x != y));
            }
            cancelled.push(cancels);
        }
        let rest = self.tangent.graph.sum(Exact::ZERO, identity);
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

/// Longer sums are lowered term by term, without an attempt to lower the whole.
const LONGEST_WHOLE: usize = 16;

#[derive(Clone, Copy)]
pub(crate) enum Way {
    /// From the normal form.
    Normal,
    /// Term by term, each in its own best way.
    Parts,
    /// A cross product, each side as a dense product or from its normal form.
    Cross(bool, bool),
}

fn transposed(dense: Dense) -> Dense {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| dense[j][i]))
}

/// A real as a linear combination of reals.
fn linear(g: &crate::vector::Graph, x: Real) -> Vec<(Exact, Real)> {
    match g.node(x.index()) {
        Node::Sum(constant, terms) if constant.is_zero() => terms.to_vec(),
        _ if g.is_zero(x) => vec![],
        _ => vec![(Exact::ONE, x)],
    }
}

/// u·v as the linear combination that the vector graph would have simplified it to.
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
