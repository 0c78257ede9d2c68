//! The saddle point system of rigid rows, factored as L D Lᵀ in lanes.
//!
//! ```text
//! [ M  Jᵀ ] [ a ]   [ f ]
//! [ J  −ε ] [ μ ] = [ γ ]
//! ```
//!
//! In: M of each body, J of each joint, f and γ. Out: a, and μ = −λ. The pattern and the order are those of
//! [`plan`](crate::system::plan); on a tree everything costs O(n). ε is zero but for joints that close loops:
//! there it is 1e-8 of what the rows feel of their bodies, so that repeated rows have a pivot.

#![expect(clippy::needless_range_loop, reason = "all ranges are constant: it becomes straight code")]

use crate::system::lanes::{Lanes, Operation, wide};
use crate::system::plan::{Node, Pair, Plan, Turn};
use nalgebra::{RealField, convert};

/// ε of the rows that close loops, relative.
const REGULARIZATION: f64 = 1e-8;

/// A pivot within a joint that is smaller than this, relative to its row, is one of a repeated row.
const REPEATED: f64 = 1e-12;

/// The matrix and its factors.
#[derive(Clone, Debug)]
pub(crate) struct Factors<R, const L: usize> {
    /// The matrix, upper triangle; after `factor` 1/D and L.
    pub(crate) matrix: Vec<Lanes<R, L>>,
    /// For each row of a joint that closes a loop ε, in the place of its row in vectors; zero elsewhere.
    pub(crate) epsilon: Vec<Lanes<R, L>>,
}

impl<R: RealField + Copy, const L: usize> Factors<R, L> {
    pub(crate) fn new(plan: &Plan) -> Factors<R, L> {
        let epsilon = vec![Lanes::zero(); plan.length];
        Factors { matrix: vec![Lanes::zero(); plan.entries], epsilon }
    }

    /// Replaces the matrix by its factors.
    pub(crate) fn factor(&mut self, plan: &Plan, arch: pulp::Arch) {
        wide::<R, L, _>(arch, Factor { plan, factors: self });
    }

    /// Replaces (f, γ) by (a, μ).
    pub(crate) fn solve(&self, plan: &Plan, vector: &mut [Lanes<R, L>], arch: pulp::Arch) {
        wide::<R, L, _>(arch, Solve { plan, matrix: &self.matrix, vector });
    }
}

/// Calls a macro for each turn of an elimination, with the sizes of its blocks as constants: `$one!(node, 6)` for
/// a node alone, `$two!(pair, 6, 3)` for a body with its joint.
macro_rules! each_turn {
    ($plan:ident, $turns:expr, $one:ident, $two:ident) => {
        for turn in $turns {
            match turn {
                Turn::Node(at) => {
                    let node = &$plan.nodes[*at];
                    match node.size {
                        1 => $one!(node, 1),
                        2 => $one!(node, 2),
                        3 => $one!(node, 3),
                        4 => $one!(node, 4),
                        5 => $one!(node, 5),
                        _ => $one!(node, 6),
                    }
                }
                Turn::Pair(pair) => match (pair.size, pair.rows) {
                    (3, 1) => $two!(pair, 3, 1),
                    (3, 2) => $two!(pair, 3, 2),
                    (3, _) => $two!(pair, 3, 3),
                    (_, 1) => $two!(pair, 6, 1),
                    (_, 2) => $two!(pair, 6, 2),
                    (_, 3) => $two!(pair, 6, 3),
                    (_, 4) => $two!(pair, 6, 4),
                    (_, 5) => $two!(pair, 6, 5),
                    _ => $two!(pair, 6, 6),
                },
            }
        }
    };
}

struct Factor<'a, R, const L: usize> {
    plan: &'a Plan,
    factors: &'a mut Factors<R, L>,
}

impl<R: RealField + Copy, const L: usize> Operation for Factor<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Factor { plan, factors } = self;
        if plan.has_loops() {
            factors.epsilon.fill(Lanes::zero());
        }
        macro_rules! one {
            ($node:ident, $n:literal) => {
                factors.eliminate::<$n>(plan, $node)
            };
        }
        macro_rules! two {
            ($pair:ident, $n:literal, $m:literal) => {
                factors.eliminate_pair::<$n, $m>($pair)
            };
        }
        each_turn!(plan, &plan.turns, one, two);
    }
}

impl<R: RealField + Copy, const L: usize> Factors<R, L> {
    #[inline(always)]
    fn eliminate<const N: usize>(&mut self, plan: &Plan, node: &Node) {
        let (done, rest) = self.matrix.split_at_mut(node.diagonal + N * N);
        let mut a: [[Lanes<R, L>; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| done[node.diagonal + i * N + j]));
        if node.is_joint {
            let epsilon = &mut self.epsilon[node.offset..node.offset + N];
            regularize(&mut a, node.closes, epsilon);
        } else {
            decompose(&mut a);
        }
        for i in 0..N {
            for j in i..N {
                done[node.diagonal + i * N + j] = a[i][j];
            }
        }
        let base = node.diagonal + N * N;
        let right = &plan.blocks[node.first..node.end];
        for block in right {
            let (width, at) = (plan.nodes[block.node].size, block.at - base);
            let block = &mut rest[at..at + N * width];
            for column in 0..width {
                let mut y: [Lanes<R, L>; N] = std::array::from_fn(|i| block[i * width + column]);
                for j in 0..N {
                    for i in j + 1..N {
                        y[i] -= a[j][i] * y[j];
                    }
                }
                for i in 0..N {
                    block[i * width + column] = y[i];
                }
            }
        }
        let mut target = node.targets;
        for (k, left) in right.iter().enumerate() {
            let (height, from) = (plan.nodes[left.node].size, left.at - base);
            for (m, block) in right[k..].iter().enumerate() {
                let (width, at) = (plan.nodes[block.node].size, block.at - base);
                let to = plan.targets[target] - base;
                target += 1;
                for row in 0..height {
                    let scaled: [Lanes<R, L>; N] =
                        std::array::from_fn(|i| rest[from + i * height + row] * a[i][i]);
                    for column in if m == 0 { row } else { 0 }..width {
                        let mut sum = rest[to + row * width + column];
                        for i in 0..N {
                            sum -= scaled[i] * rest[at + i * width + column];
                        }
                        rest[to + row * width + column] = sum;
                    }
                }
            }
            // What a joint that closes a loop feels of this body is the measure of its ε.
            let joint = &plan.nodes[left.node];
            if joint.closes && !node.is_joint {
                for row in 0..height {
                    let felt = (0..N).fold(Lanes::zero(), |sum: Lanes<R, L>, i| {
                        let y = rest[from + i * height + row];
                        sum + y * y * a[i][i]
                    });
                    self.epsilon[joint.offset + row] += felt;
                }
            }
        }
    }
}

/// `N` numbers that begin at a place.
#[inline(always)]
fn part<T, const N: usize>(all: &[T], at: usize) -> &[T; N] {
    all[at..].first_chunk().expect("a block of the plan")
}

#[inline(always)]
fn part_mut<T, const N: usize>(all: &mut [T], at: usize) -> &mut [T; N] {
    all[at..].first_chunk_mut().expect("a block of the plan")
}

impl<R: RealField + Copy, const L: usize> Factors<R, L> {
    /// The same as eliminating the body and then the joint, whose own block is zero so far.
    #[inline(always)]
    fn eliminate_pair<const N: usize, const M: usize>(&mut self, pair: &Pair) {
        let matrix = &mut self.matrix[..];
        let zero = Lanes::zero();
        let mut a = [[zero; N]; N];
        for i in 0..N {
            a[i] = *part(matrix, pair.mass + i * N);
        }
        decompose(&mut a);
        let mut y = [[zero; M]; N];
        for i in 0..N {
            y[i] = *part(matrix, pair.jacobian + i * M);
        }
        for j in 0..N {
            for i in j + 1..N {
                for k in 0..M {
                    let known = y[j][k];
                    y[i][k] -= a[j][i] * known;
                }
            }
        }
        let mut s = [[zero; M]; M];
        for row in 0..M {
            for i in 0..N {
                let scaled = y[i][row] * a[i][i];
                for column in row..M {
                    s[row][column] -= scaled * y[i][column];
                }
            }
        }
        for i in 0..N {
            *part_mut(matrix, pair.mass + i * N) = a[i];
            *part_mut(matrix, pair.jacobian + i * M) = y[i];
        }
        regularize(&mut s, false, &mut []);
        for i in 0..M {
            *part_mut(matrix, pair.schur + i * M) = s[i];
        }
        let Some(above) = &pair.above else { return };
        let mut z = [[zero; N]; M];
        for i in 0..M {
            z[i] = *part(matrix, above.jacobian + i * N);
        }
        for j in 0..M {
            for i in j + 1..M {
                for k in 0..N {
                    let known = z[j][k];
                    z[i][k] -= s[j][i] * known;
                }
            }
        }
        for i in 0..M {
            *part_mut(matrix, above.jacobian + i * N) = z[i];
        }
        for row in 0..N {
            let sums: &mut [Lanes<R, L>; N] = part_mut(matrix, above.mass + row * N);
            for i in 0..M {
                let scaled = z[i][row] * s[i][i];
                for column in row..N {
                    sums[column] -= scaled * z[i][column];
                }
            }
        }
    }
}

#[inline(always)]
fn forward_pair<R: RealField + Copy, const L: usize, const N: usize, const M: usize>(
    pair: &Pair,
    matrix: &[Lanes<R, L>],
    vector: &mut [Lanes<R, L>],
) {
    let mut y: [Lanes<R, L>; N] = *part(vector, pair.body);
    for j in 0..N {
        let row: &[Lanes<R, L>; N] = part(matrix, pair.mass + j * N);
        for i in j + 1..N {
            let known = y[j];
            y[i] -= row[i] * known;
        }
        y[j] = y[j] * row[j];
    }
    *part_mut(vector, pair.body) = y;
    let mut g: [Lanes<R, L>; M] = *part(vector, pair.joint);
    for i in 0..N {
        let row: &[Lanes<R, L>; M] = part(matrix, pair.jacobian + i * M);
        for k in 0..M {
            g[k] -= row[k] * y[i];
        }
    }
    for j in 0..M {
        let row: &[Lanes<R, L>; M] = part(matrix, pair.schur + j * M);
        for i in j + 1..M {
            let known = g[j];
            g[i] -= row[i] * known;
        }
        g[j] = g[j] * row[j];
    }
    *part_mut(vector, pair.joint) = g;
    let Some(above) = &pair.above else { return };
    let sums: &mut [Lanes<R, L>; N] = part_mut(vector, above.body);
    for i in 0..M {
        let row: &[Lanes<R, L>; N] = part(matrix, above.jacobian + i * N);
        for k in 0..N {
            sums[k] -= row[k] * g[i];
        }
    }
}

#[inline(always)]
fn backward_pair<R: RealField + Copy, const L: usize, const N: usize, const M: usize>(
    pair: &Pair,
    matrix: &[Lanes<R, L>],
    vector: &mut [Lanes<R, L>],
) {
    let mut g: [Lanes<R, L>; M] = *part(vector, pair.joint);
    if let Some(above) = &pair.above {
        let known: [Lanes<R, L>; N] = *part(vector, above.body);
        for i in 0..M {
            let row: &[Lanes<R, L>; N] = part(matrix, above.jacobian + i * N);
            let mut sum = Lanes::zero();
            for k in 0..N {
                sum += row[k] * known[k];
            }
            g[i] -= sum * matrix[pair.schur + i * M + i];
        }
    }
    for i in (0..M).rev() {
        let row: &[Lanes<R, L>; M] = part(matrix, pair.schur + i * M);
        for j in i + 1..M {
            let known = g[j];
            g[i] -= row[j] * known;
        }
    }
    *part_mut(vector, pair.joint) = g;
    let mut x: [Lanes<R, L>; N] = *part(vector, pair.body);
    for i in (0..N).rev() {
        let row: &[Lanes<R, L>; M] = part(matrix, pair.jacobian + i * M);
        let own: &[Lanes<R, L>; N] = part(matrix, pair.mass + i * N);
        let mut sum = Lanes::zero();
        for k in 0..M {
            sum += row[k] * g[k];
        }
        x[i] -= sum * own[i];
        for j in i + 1..N {
            let known = x[j];
            x[i] -= own[j] * known;
        }
    }
    *part_mut(vector, pair.body) = x;
}

/// A = Lᵀ D L: 1/D on the diagonal, L above it.
#[inline(always)]
fn decompose<R: RealField + Copy, const L: usize, const N: usize>(a: &mut [[Lanes<R, L>; N]; N]) {
    for j in 0..N {
        pivot(a, j);
    }
}

/// One step of it: divides row j by its pivot, and subtracts it from the rows below.
#[inline(always)]
fn pivot<R: RealField + Copy, const L: usize, const N: usize>(a: &mut [[Lanes<R, L>; N]; N], j: usize) {
    let inverse = a[j][j].recip();
    for i in j + 1..N {
        let factor = a[j][i] * inverse;
        for k in i..N {
            let above = a[j][k];
            a[i][k] -= factor * above;
        }
    }
    for i in j + 1..N {
        a[j][i] = a[j][i] * inverse;
    }
    a[j][j] = inverse;
}

/// The same for the block of a joint, which is negative: with ε where it closes a loop, given what its rows
/// feel, and where a pivot is that of a repeated row.
#[inline(always)]
fn regularize<R: RealField + Copy, const L: usize, const N: usize>(
    a: &mut [[Lanes<R, L>; N]; N],
    closes: bool,
    epsilon: &mut [Lanes<R, L>],
) {
    let number = |x: f64| Lanes::<R, L>::all(convert(x));
    let mut whole: [Lanes<R, L>; N] = std::array::from_fn(|i| -a[i][i]);
    if closes {
        for i in 0..N {
            whole[i] = whole[i].map_with(epsilon[i], |a, b| if a > b { a } else { b });
            epsilon[i] = whole[i] * number(REGULARIZATION);
            a[i][i] -= epsilon[i];
        }
    }
    let few = Lanes::all(convert::<f64, R>(REPEATED).max(R::default_epsilon() * convert(100.0)));
    for j in 0..N {
        let weak: [bool; L] = std::array::from_fn(|k| -a[j][j].0[k] <= (few * whole[j]).0[k]);
        if weak.contains(&true) {
            let least = whole[j] * number(REGULARIZATION);
            a[j][j] = a[j][j].or_if(-least, weak);
        }
        pivot(a, j);
    }
}

struct Solve<'a, R, const L: usize> {
    plan: &'a Plan,
    matrix: &'a [Lanes<R, L>],
    vector: &'a mut [Lanes<R, L>],
}

impl<R: RealField + Copy, const L: usize> Operation for Solve<'_, R, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Solve { plan, matrix, vector } = self;
        macro_rules! one {
            ($node:ident, $n:literal) => {
                forward::<R, L, $n>(plan, $node, matrix, vector)
            };
        }
        macro_rules! two {
            ($pair:ident, $n:literal, $m:literal) => {
                forward_pair::<R, L, $n, $m>($pair, matrix, vector)
            };
        }
        each_turn!(plan, &plan.turns, one, two);
        macro_rules! one_back {
            ($node:ident, $n:literal) => {
                backward::<R, L, $n>(plan, $node, matrix, vector)
            };
        }
        macro_rules! two_back {
            ($pair:ident, $n:literal, $m:literal) => {
                backward_pair::<R, L, $n, $m>($pair, matrix, vector)
            };
        }
        each_turn!(plan, plan.turns.iter().rev(), one_back, two_back);
    }
}

#[inline(always)]
fn forward<R: RealField + Copy, const L: usize, const N: usize>(
    plan: &Plan,
    node: &Node,
    matrix: &[Lanes<R, L>],
    vector: &mut [Lanes<R, L>],
) {
    let a = &matrix[node.diagonal..node.diagonal + N * N];
    let mut y: [Lanes<R, L>; N] = std::array::from_fn(|i| vector[node.offset + i]);
    for j in 0..N {
        for i in j + 1..N {
            y[i] -= a[j * N + i] * y[j];
        }
    }
    for i in 0..N {
        y[i] = y[i] * a[i * N + i];
        vector[node.offset + i] = y[i];
    }
    for right in &plan.blocks[node.first..node.end] {
        let other = &plan.nodes[right.node];
        let block = &matrix[right.at..right.at + N * other.size];
        let below = &mut vector[other.offset..other.offset + other.size];
        for (column, sum) in below.iter_mut().enumerate() {
            let mut rest = *sum;
            for i in 0..N {
                rest -= block[i * other.size + column] * y[i];
            }
            *sum = rest;
        }
    }
}

#[inline(always)]
fn backward<R: RealField + Copy, const L: usize, const N: usize>(
    plan: &Plan,
    node: &Node,
    matrix: &[Lanes<R, L>],
    vector: &mut [Lanes<R, L>],
) {
    let a = &matrix[node.diagonal..node.diagonal + N * N];
    let mut sum = [Lanes::<R, L>::zero(); N];
    for right in &plan.blocks[node.first..node.end] {
        let other = &plan.nodes[right.node];
        let block = &matrix[right.at..right.at + N * other.size];
        let known = &vector[other.offset..other.offset + other.size];
        for (i, sum) in sum.iter_mut().enumerate() {
            for (entry, x) in block[i * other.size..(i + 1) * other.size].iter().zip(known) {
                *sum += *entry * *x;
            }
        }
    }
    let mut x: [Lanes<R, L>; N] = std::array::from_fn(|i| vector[node.offset + i] - sum[i] * a[i * N + i]);
    for i in (0..N).rev() {
        for j in i + 1..N {
            let known = x[j];
            x[i] -= a[i * N + j] * known;
        }
    }
    for i in 0..N {
        vector[node.offset + i] = x[i];
    }
}
