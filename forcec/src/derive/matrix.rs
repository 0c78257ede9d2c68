//! The closed algebra of derivatives of a vector by a vector: M = s I + [k]× + Σ u vᵀ.
//!
//! In: nodes of the vector graph. Out: matrices whose parts are nodes again. The algebra is closed under all that
//! differentiation does: sums, products with reals, cross products and rotations from the left. The rules:
//!
//! ```text
//! [a]× [b]× = b aᵀ − (a·b) I        [a]× u vᵀ = (a × u) vᵀ        gᵀ [k]× = (g × k)ᵀ
//! ```
//!
//! Outer products with a common left or right vector are merged as they appear.

use crate::exact::Exact;
use crate::vector::{Graph, Node, Real, Vector};
use std::collections::BTreeMap;

/// s I + [k]× + Σ u vᵀ
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Matrix {
    /// s
    pub identity: Real,
    /// k
    pub skew: Vector,
    /// u, v
    pub outer: Vec<(Vector, Vector)>,
}

impl Matrix {
    /// The zero matrix.
    pub fn zero(g: &mut Graph) -> Matrix {
        Matrix { identity: g.zero(), skew: g.zero_vector(), outer: Vec::new() }
    }

    /// s I
    pub fn identity(g: &mut Graph, s: Real) -> Matrix {
        Matrix { identity: s, ..Matrix::zero(g) }
    }

    /// [k]×
    pub fn skew(g: &mut Graph, k: Vector) -> Matrix {
        Matrix { skew: k, ..Matrix::zero(g) }
    }

    /// Σ u vᵀ
    pub fn outer(g: &mut Graph, outer: Vec<(Vector, Vector)>) -> Matrix {
        Matrix { outer: merge(g, outer), ..Matrix::zero(g) }
    }

    /// Whether every part is zero.
    pub fn is_zero(&self, g: &Graph) -> bool {
        g.is_zero(self.identity) && g.is_zero_vector(self.skew) && self.outer.is_empty()
    }

    /// Σ coefficient · matrix
    pub fn sum(g: &mut Graph, terms: &[(Exact, &Matrix)]) -> Matrix {
        let mut outer = Vec::new();
        for (c, m) in terms {
            for &(u, v) in &m.outer {
                outer.push((u, g.vector_sum(vec![(c.clone(), v)])));
            }
        }
        Matrix {
            identity: g.sum(Exact::ZERO, terms.iter().map(|(c, m)| (c.clone(), m.identity)).collect()),
            skew: g.vector_sum(terms.iter().map(|(c, m)| (c.clone(), m.skew)).collect()),
            outer: merge(g, outer),
        }
    }

    /// x M for a real x
    pub fn scale(&self, g: &mut Graph, x: Real) -> Matrix {
        let outer = self.outer.iter().map(|&(u, v)| (u, g.scale(x, v))).collect();
        Matrix { identity: g.mul(x, self.identity), skew: g.scale(x, self.skew), outer: merge(g, outer) }
    }

    /// [a]× M
    pub fn cross_left(&self, g: &mut Graph, a: Vector) -> Matrix {
        let along = g.dot(a, self.skew);
        let mut outer = vec![(self.skew, a)];
        outer.extend(self.outer.iter().map(|&(u, v)| (g.cross(a, u), v)));
        Matrix { identity: g.neg(along), skew: g.scale(self.identity, a), outer: merge(g, outer) }
    }

    /// gᵀ M as a vector
    pub fn row_times(&self, g: &mut Graph, row: Vector) -> Vector {
        let mut terms =
            vec![(Exact::ONE, g.scale(self.identity, row)), (Exact::ONE, g.cross(row, self.skew))];
        for &(u, v) in &self.outer {
            let along = g.dot(row, u);
            terms.push((Exact::ONE, g.scale(along, v)));
        }
        g.vector_sum(terms)
    }

    /// R M for the rotation of a stored quaternion, or of its inverse.
    pub fn rotate_left(&self, g: &mut Graph, quaternion: crate::bodies::Slot, inverse: bool) -> Matrix {
        let mut outer: Vec<(Vector, Vector)> =
            self.outer.iter().map(|&(u, v)| (g.rotate(quaternion, inverse, u), v)).collect();
        if !g.is_zero(self.identity) || !g.is_zero_vector(self.skew) {
            for axis in 0..3 {
                let basis = g.basis(axis);
                let column = g.rotate(quaternion, inverse, basis);
                let square = Matrix { outer: Vec::new(), ..self.clone() };
                let row = square.row_times(g, basis);
                outer.push((column, row));
            }
        }
        Matrix::outer(g, outer)
    }
}

/// Sums outer products: zero ones dropped, numbers and reals moved right, those with a common side joined.
fn merge(g: &mut Graph, outer: Vec<(Vector, Vector)>) -> Vec<(Vector, Vector)> {
    let mut products: Vec<(Vector, Vector)> = Vec::with_capacity(outer.len());
    for (u, v) in outer {
        let (c, mut left) = g.split_vector(u);
        let mut right = g.vector_sum(vec![(c, v)]);
        if let Node::Scale(s, inner) = *g.node(left.index()) {
            left = inner;
            right = g.scale(s, right);
        }
        if !g.is_zero_vector(left) && !g.is_zero_vector(right) {
            products.push((left, right));
        }
    }
    loop {
        let before = products.len();
        products = join(g, products, false);
        products = join(g, products, true);
        if products.len() >= before {
            products.sort();
            return products;
        }
    }
}

/// Joins products with the same left vector, or with `by_right` the same right one up to a number.
fn join(g: &mut Graph, products: Vec<(Vector, Vector)>, by_right: bool) -> Vec<(Vector, Vector)> {
    let mut groups: BTreeMap<Vector, Vec<(Exact, Vector)>> = BTreeMap::new();
    for (u, v) in products {
        let (key, other) = if by_right { (v, u) } else { (u, v) };
        let (ck, key) = g.split_vector(key);
        let (co, other) = g.split_vector(other);
        groups.entry(key).or_default().push((&ck * &co, other));
    }
    let mut joined = Vec::new();
    for (key, others) in groups {
        let sum = g.vector_sum(others);
        if !g.is_zero_vector(sum) {
            joined.push(if by_right { (sum, key) } else { (key, sum) });
        }
    }
    joined
}
