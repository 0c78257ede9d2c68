//! Sparse linear systems of 6 × 6 blocks, solved by block elimination.
//!
//! In go the pairs of nodes that forces couple; out comes an order of elimination by least degree, the fill it makes, and
//! storage for both, kept while the pairs stay. On a tree there is no fill and a solve is O(n). Blocks need not be
//! symmetric, their pattern is. Nodes are renumbered: node i is the i-th that is eliminated. Diagonal blocks are
//! factored without pivoting; whoever solves checks the residual.

use nalgebra::{Matrix6, RealField, Vector6};
use std::collections::BTreeSet;

/// The matrix of a step, its factors and its right-hand side.
#[derive(Clone, Debug)]
pub(crate) struct System<R: RealField> {
    /// Blocks right of the diagonal in row i, and below it in column i: `start[i]..start[i + 1]`.
    start: Vec<usize>,
    /// The later node of each such block, ascending in a row.
    later: Vec<usize>,
    matrix: Blocks<R>,
    factors: Blocks<R>,
    /// The right-hand side, then the solution.
    pub(crate) rhs: Vec<Vector6<R>>,
    work: Vec<Vector6<R>>,
}

#[derive(Clone, Debug)]
struct Blocks<R: RealField> {
    diagonal: Vec<Matrix6<R>>,
    upper: Vec<Matrix6<R>>,
    lower: Vec<Matrix6<R>>,
}

impl<R: RealField + Copy> Blocks<R> {
    fn zeros(nodes: usize, pairs: usize) -> Blocks<R> {
        let zero = Matrix6::zeros();
        Blocks { diagonal: vec![zero; nodes], upper: vec![zero; pairs], lower: vec![zero; pairs] }
    }

    fn copy_from(&mut self, other: &Blocks<R>) {
        self.diagonal.copy_from_slice(&other.diagonal);
        self.upper.copy_from_slice(&other.upper);
        self.lower.copy_from_slice(&other.lower);
    }
}

impl<R: RealField + Copy> Default for System<R> {
    fn default() -> System<R> {
        System {
            start: Vec::new(),
            later: Vec::new(),
            matrix: Blocks::zeros(0, 0),
            factors: Blocks::zeros(0, 0),
            rhs: Vec::new(),
            work: Vec::new(),
        }
    }
}

impl<R: RealField + Copy> System<R> {
    /// A system over nodes with these neighbours, and for each node its place in the order of elimination.
    pub(crate) fn new(mut neighbours: Vec<BTreeSet<usize>>) -> (System<R>, Vec<usize>) {
        let nodes = neighbours.len();
        let mut queue: BTreeSet<(usize, usize)> =
            neighbours.iter().enumerate().map(|(node, near)| (near.len(), node)).collect();
        let mut place = vec![0; nodes];
        let mut rows = Vec::with_capacity(nodes);
        while let Some((_, node)) = queue.pop_first() {
            place[node] = rows.len();
            let near = std::mem::take(&mut neighbours[node]);
            for &other in &near {
                let set = &mut neighbours[other];
                queue.remove(&(set.len(), other));
                set.remove(&node);
                set.extend(near.iter().filter(|&&third| third != other));
                queue.insert((set.len(), other));
            }
            rows.push(near);
        }
        let (mut start, mut later) = (vec![0], Vec::new());
        for row in rows {
            let first = later.len();
            later.extend(row.into_iter().map(|node| place[node]));
            later[first..].sort_unstable();
            start.push(later.len());
        }
        let matrix = Blocks::zeros(nodes, later.len());
        let factors = matrix.clone();
        let zero = Vector6::zeros();
        let system =
            System { start, later, matrix, factors, rhs: vec![zero; nodes], work: vec![zero; nodes] };
        (system, place)
    }

    /// Empties the matrix.
    pub(crate) fn clear(&mut self) {
        let Blocks { diagonal, upper, lower } = &mut self.matrix;
        for blocks in [diagonal, upper, lower] {
            blocks.fill(Matrix6::zeros());
        }
    }

    /// The block in this row and column, which a force couples.
    pub(crate) fn block(&mut self, row: usize, column: usize) -> &mut Matrix6<R> {
        entry(&mut self.matrix, &self.start, &self.later, row, column)
    }

    /// Replaces the right-hand side by the solution and returns the relative residual.
    pub(crate) fn solve(&mut self) -> R {
        self.work.copy_from_slice(&self.rhs);
        self.factors.copy_from(&self.matrix);
        self.factor();
        self.substitute();
        self.residual()
    }

    fn factor(&mut self) {
        for node in 0..self.rhs.len() {
            let row = self.start[node]..self.start[node + 1];
            factor_block(&mut self.factors.diagonal[node]);
            let diagonal = self.factors.diagonal[node];
            for at in row.clone() {
                solve_block(&diagonal, &mut self.factors.upper[at]);
            }
            for below in row.clone() {
                let lower = self.factors.lower[below];
                for right in row.clone() {
                    let change = lower * self.factors.upper[right];
                    let (i, j) = (self.later[below], self.later[right]);
                    *entry(&mut self.factors, &self.start, &self.later, i, j) -= change;
                }
            }
        }
    }

    fn substitute(&mut self) {
        for node in 0..self.rhs.len() {
            let mut value = self.rhs[node];
            solve_block(&self.factors.diagonal[node], &mut value);
            self.rhs[node] = value;
            for at in self.start[node]..self.start[node + 1] {
                self.rhs[self.later[at]] -= self.factors.lower[at] * value;
            }
        }
        for node in (0..self.rhs.len()).rev() {
            let mut value = self.rhs[node];
            for at in self.start[node]..self.start[node + 1] {
                value -= self.factors.upper[at] * self.rhs[self.later[at]];
            }
            self.rhs[node] = value;
        }
    }

    /// |b − A x| / |b|, where `work` is b.
    fn residual(&mut self) -> R {
        let size = self.work.iter().fold(R::zero(), |sum, b| sum + b.norm_squared());
        for node in 0..self.rhs.len() {
            let own = self.matrix.diagonal[node] * self.rhs[node];
            self.work[node] -= own;
            for at in self.start[node]..self.start[node + 1] {
                let other = self.later[at];
                self.work[node] -= self.matrix.upper[at] * self.rhs[other];
                self.work[other] -= self.matrix.lower[at] * self.rhs[node];
            }
        }
        let rest = self.work.iter().fold(R::zero(), |sum, r| sum + r.norm_squared());
        if rest == R::zero() { rest } else { (rest / size).sqrt() }
    }
}

fn entry<'a, R: RealField>(
    blocks: &'a mut Blocks<R>,
    start: &[usize],
    later: &[usize],
    row: usize,
    column: usize,
) -> &'a mut Matrix6<R> {
    if row == column {
        return &mut blocks.diagonal[row];
    }
    let (first, second) = (row.min(column), row.max(column));
    let place = later[start[first]..start[first + 1]].partition_point(|&node| node < second);
    let at = start[first] + place;
    debug_assert_eq!(later[at], second);
    if row < column { &mut blocks.upper[at] } else { &mut blocks.lower[at] }
}

/// A = L U in place, the diagonal of L being one; the diagonal of U is inverted.
fn factor_block<R: RealField + Copy>(a: &mut Matrix6<R>) {
    for k in 0..6 {
        let inverse = R::one() / a[(k, k)];
        a[(k, k)] = inverse;
        for i in k + 1..6 {
            a[(i, k)] *= inverse;
        }
        for j in k + 1..6 {
            let top = a[(k, j)];
            for i in k + 1..6 {
                let left = a[(i, k)];
                a[(i, j)] -= left * top;
            }
        }
    }
}

/// X becomes A⁻¹ X, where `lu` is what `factor_block` made of A.
fn solve_block<R: RealField + Copy, const COLUMNS: usize>(
    lu: &Matrix6<R>,
    x: &mut nalgebra::SMatrix<R, 6, COLUMNS>,
) {
    for column in 0..COLUMNS {
        for k in 0..6 {
            let value = x[(k, column)];
            for i in k + 1..6 {
                x[(i, column)] -= lu[(i, k)] * value;
            }
        }
        for k in (0..6).rev() {
            let value = x[(k, column)] * lu[(k, k)];
            x[(k, column)] = value;
            for i in 0..k {
                x[(i, column)] -= lu[(i, k)] * value;
            }
        }
    }
}
