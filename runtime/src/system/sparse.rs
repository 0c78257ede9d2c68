//! Sparse linear systems of D × D blocks: pattern, and direct solution by block elimination.
//!
//! In: the pairs of nodes that forces couple. Out: an elimination order of minimum degree, with independent
//! nodes grouped in levels, and storage for the matrix and its fill, reused while the pairs stay the same. A
//! tree has no fill, and a solve costs O(n). The pattern is symmetric, the blocks need not be. Nodes are
//! renumbered in elimination order. Diagonal blocks are factored without pivoting; the caller checks the
//! residual. [`iterative`](crate::system::iterative) contains other solvers.

use crate::system::block::Block;
use crate::system::order::eliminate;
use nalgebra::{RealField, SVector};
use std::collections::BTreeSet;

/// The matrix of a step, with factors and right-hand side.
#[derive(Clone, Debug)]
pub(crate) struct System<R: RealField, const D: usize> {
    /// The end of each level, a run of nodes whose eliminations are independent.
    levels: Vec<usize>,
    /// The off-diagonal blocks of each node, right of the diagonal and below: `start[i]..start[i + 1]`.
    start: Vec<usize>,
    /// The later node of each off-diagonal block, ascending in each row.
    later: Vec<usize>,
    /// The block that elimination changes, for each pair of a node's later nodes in order.
    targets: Vec<u32>,
    /// Whether elimination changes each upper and lower block, in the order of `later`.
    changed: Vec<bool>,
    /// Position, row and column of every block except fill, by rows of the upper triangle.
    pattern: Vec<[u32; 3]>,
    /// The diagonal, then the upper, then the lower blocks.
    pub(crate) blocks: Vec<Block<R, D>>,
    pub(crate) factors: Vec<Block<R, D>>,
    /// The part of each node if the system is cut; else empty.
    pub(crate) parts: Vec<u32>,
    /// The right-hand side, then the solution.
    pub(crate) rhs: Vec<SVector<R, D>>,
    /// A copy of the right-hand side, then the residual.
    work: Vec<SVector<R, D>>,
}

impl<R: RealField + Copy, const D: usize> Default for System<R, D> {
    fn default() -> System<R, D> {
        System::new(&[], &[]).0
    }
}

impl<R: RealField + Copy, const D: usize> System<R, D> {
    /// A system for nodes with these neighbours and with nodes that precede each, which must be neighbours too;
    /// and each node's position in the elimination order.
    pub(crate) fn new(
        neighbours: &[BTreeSet<usize>],
        predecessors: &[Vec<usize>],
    ) -> (System<R, D>, Vec<usize>) {
        let (coupled, nodes) = (neighbours, neighbours.len());
        let mut rows = eliminate(neighbours, predecessors);
        // The number of eliminations that must precede a node; nodes with equal numbers form a level.
        let mut levels = vec![0; nodes];
        for (node, near) in &rows {
            near.iter().for_each(|&other| levels[other] = levels[other].max(levels[*node] + 1));
        }
        rows.sort_by_key(|&(node, _)| levels[node]);
        let ends =
            (1..=nodes).filter(|&at| at == nodes || levels[rows[at - 1].0] < levels[rows[at].0]).collect();
        let mut place = vec![0; nodes];
        for (at, &(node, _)) in rows.iter().enumerate() {
            place[node] = at;
        }
        let (mut start, mut later) = (vec![0], Vec::new());
        for (_, row) in rows {
            let first = later.len();
            later.extend(row.into_iter().map(|node| place[node]));
            later[first..].sort_unstable();
            start.push(later.len());
        }
        let mut system = System {
            levels: ends,
            start,
            later,
            targets: Vec::new(),
            changed: Vec::new(),
            pattern: Vec::new(),
            blocks: Vec::new(),
            factors: Vec::new(),
            parts: Vec::new(),
            rhs: vec![SVector::zeros(); nodes],
            work: vec![SVector::zeros(); nodes],
        };
        system.blocks = vec![Block::zeros(); nodes + 2 * system.later.len()];
        system.factors = system.blocks.clone();
        for node in 0..nodes {
            let row = &system.later[system.start[node]..system.start[node + 1]];
            let pairs = row.iter().flat_map(|&i| row.iter().map(move |&j| (i, j)));
            let targets: Vec<u32> = pairs.map(|(i, j)| system.place(i, j) as u32).collect();
            system.targets.extend(targets);
        }
        system.changed = vec![false; 2 * system.later.len()];
        for &target in system.targets.iter().filter(|&&target| target as usize >= nodes) {
            system.changed[target as usize - nodes] = true;
        }
        let mut pairs: Vec<(usize, usize)> = (0..nodes).map(|node| (node, node)).collect();
        let ordered = |(node, near): (usize, &BTreeSet<usize>)| {
            let (place, row) = (&place, place[node]);
            near.iter().map(move |&other| (row, place[other])).collect::<Vec<_>>()
        };
        pairs.extend(coupled.iter().enumerate().flat_map(ordered));
        pairs.sort_unstable_by_key(|&(row, column)| (row.min(column), row.max(column), row));
        let places = pairs.into_iter().map(|(row, column)| [system.place(row, column), row, column]);
        system.pattern = places.map(|block| block.map(|x| x as u32)).collect();
        (system, place)
    }

    /// The number of nodes.
    pub(crate) fn nodes(&self) -> usize {
        self.start.len() - 1
    }

    /// The number of block products in an elimination.
    pub(crate) fn products(&self) -> usize {
        self.targets.len()
    }

    /// Sets the matrix to zero.
    pub(crate) fn clear(&mut self) {
        self.blocks.fill(Block::zeros());
    }

    /// The position in `blocks` of the block in this row and column, which a force must couple.
    pub(crate) fn place(&self, row: usize, column: usize) -> usize {
        if row == column {
            return row;
        }
        let (first, second) = (row.min(column), row.max(column));
        let range = self.start[first]..self.start[first + 1];
        let at = range.start + self.later[range].partition_point(|&node| node < second);
        debug_assert_eq!(self.later[at], second);
        self.nodes() + at + if row < column { 0 } else { self.later.len() }
    }

    fn is_kept(&self, node: usize, other: usize) -> bool {
        self.parts.is_empty() || self.parts[node] == self.parts[other]
    }

    /// Replaces the right-hand side by the solution; keeps a copy for the residual.
    pub(crate) fn solve(&mut self) {
        self.factor();
        self.solve_again();
    }

    /// The same with the existing factors.
    pub(crate) fn solve_again(&mut self) {
        self.keep_rhs();
        self.substitute();
    }

    pub(crate) fn factor(&mut self) {
        let (nodes, count) = (self.nodes(), self.later.len());
        let mut factors = std::mem::take(&mut self.factors);
        let (diagonals, others) = factors.split_at_mut(nodes);
        let blocks = &self.blocks[nodes..];
        diagonals.copy_from_slice(&self.blocks[..nodes]);
        for at in (0..2 * count).filter(|&at| self.changed[at]) {
            others[at] = blocks[at];
        }
        let (mut targets, mut first) = (self.targets.as_slice(), 0);
        for &end in &self.levels {
            let level = std::mem::replace(&mut first, end)..end;
            // A factorisation is a chain of divisions; independent ones of a level overlap in the processor.
            diagonals[level.clone()].iter_mut().for_each(Block::factor);
            for node in level.clone() {
                for at in
                    (self.start[node]..self.start[node + 1]).filter(|&at| self.is_kept(node, self.later[at]))
                {
                    if !self.changed[at] {
                        others[at] = blocks[at];
                    }
                    diagonals[node].solve_block(&mut others[at]);
                }
            }
            for node in level {
                let row = self.start[node]..self.start[node + 1];
                let is_kept = |at: usize| self.is_kept(node, self.later[at]);
                for below in row.clone() {
                    let (own, rest) = targets.split_at(row.len());
                    targets = rest;
                    if !is_kept(below) {
                        continue;
                    }
                    let changed;
                    let lower = if self.changed[count + below] {
                        changed = others[count + below];
                        &changed
                    } else {
                        &blocks[count + below]
                    };
                    for (right, &target) in row.clone().zip(own) {
                        if !is_kept(right) {
                            continue;
                        }
                        if let Some(sum) = diagonals.get_mut(target as usize) {
                            sum.subtract_product(lower, &others[right]);
                        } else {
                            let upper = others[right];
                            others[target as usize - nodes].subtract_product(lower, &upper);
                        }
                    }
                }
            }
        }
        self.factors = factors;
    }

    /// A lower block at the time when its node is eliminated.
    fn lower(&self, at: usize) -> &Block<R, D> {
        let count = self.later.len();
        let blocks = if self.changed[count + at] { &self.factors } else { &self.blocks };
        &blocks[self.nodes() + count + at]
    }

    fn substitute(&mut self) {
        let mut rhs = std::mem::take(&mut self.rhs);
        let nodes = rhs.len();
        for node in 0..nodes {
            let mut value = rhs[node];
            self.factors[node].solve(&mut value);
            rhs[node] = value;
            for at in self.start[node]..self.start[node + 1] {
                let other = self.later[at];
                if self.is_kept(node, other) {
                    rhs[other] -= self.lower(at).times(&value);
                }
            }
        }
        for node in (0..nodes).rev() {
            let mut value = rhs[node];
            for at in self.start[node]..self.start[node + 1] {
                let other = self.later[at];
                if self.is_kept(node, other) {
                    value -= self.factors[nodes + at].times(&rhs[other]);
                }
            }
            rhs[node] = value;
        }
        self.rhs = rhs;
    }

    /// |b − A x| / |b|, where `work` is b and `rhs` is x.
    pub(crate) fn residual(&mut self) -> R {
        let size = self.work.iter().fold(R::zero(), |sum, b| sum + b.norm_squared());
        let mut work = std::mem::take(&mut self.work);
        self.each_block(|place, row, column| work[row] -= self.blocks[place].times(&self.rhs[column]));
        let rest = work.iter().fold(R::zero(), |sum, r| sum + r.norm_squared());
        self.work = work;
        if rest == R::zero() { rest } else { (rest / size).sqrt() }
    }

    /// Copies the right-hand side for the residual.
    pub(crate) fn keep_rhs(&mut self) {
        self.work.copy_from_slice(&self.rhs);
    }

    /// y = A x.
    pub(crate) fn multiply(&self, x: &[SVector<R, D>], y: &mut [SVector<R, D>]) {
        y.fill(SVector::zeros());
        self.add_product(&self.blocks, x, y);
    }

    /// y += B x for blocks B in the pattern of this system.
    pub(crate) fn add_product(&self, blocks: &[Block<R, D>], x: &[SVector<R, D>], y: &mut [SVector<R, D>]) {
        self.each_block(|place, row, column| y[row] += blocks[place].times(&x[column]));
    }

    /// Visits every block that is neither fill nor cut: position, row and column.
    pub(crate) fn each_block(&self, mut visit: impl FnMut(usize, usize, usize)) {
        for block in &self.pattern {
            let [place, row, column] = block.map(|x| x as usize);
            if self.is_kept(row, column) {
                visit(place, row, column);
            }
        }
    }

    /// y = Aᵀ x.
    pub(crate) fn multiply_transposed(&self, x: &[SVector<R, D>], y: &mut [SVector<R, D>]) {
        y.fill(SVector::zeros());
        self.each_block(|place, row, column| y[column] += self.blocks[place].transposed_times(&x[row]));
    }
}
