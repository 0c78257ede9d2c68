//! The closed algebra of derivatives of a vector by a vector: `M = s I + [k]× + Σ u vᵀ + (s′ I + [k′]×) R`.
//!
//! In: nodes of the vector graph. Out: matrices whose parts are nodes of the graph. The operations of
//! differentiation preserve this form: sums, products with reals, cross products and rotations from the left.
//! The rules:
//!
//! ```text
//! [a]× [b]× = b aᵀ − (a·b) I        [a]× u vᵀ = (a × u) vᵀ        gᵀ [k]× = (g × k)ᵀ        Rᵀ [k]× R = [Rᵀ k]×
//! ```
//!
//! Outer products with a common left or right vector are merged immediately. The last part, with R a product
//! of stored rotations, comes from relative orientations; R⁻¹ from the left removes it.

use crate::math::exact::Exact;
use crate::model::bodies::Slot;
use crate::vector::{Graph, Node, Real, Vector};
use std::collections::BTreeMap;

/// `s I + [k]× + Σ u vᵀ + (s′ I + [k′]×) R`
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Matrix {
    /// s
    pub identity: Real,
    /// k
    pub skew: Vector,
    /// u, v
    pub outer: Vec<(Vector, Vector)>,
    /// s′, k′ and R
    pub turned: Option<RotatedBlock>,
}

/// `(s I + [k]×) R` for a product of stored rotations, each inverted or not, at least one.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RotatedBlock {
    /// s
    pub identity: Real,
    /// k
    pub skew: Vector,
    /// The factors of R, left to right.
    pub rotations: Vec<(Slot, bool)>,
}

impl RotatedBlock {
    /// R⁻¹ v
    fn unrotate(&self, g: &mut Graph, v: Vector) -> Vector {
        self.rotations.iter().fold(v, |v, (slot, inverse)| g.rotate(*slot, !inverse, v))
    }

    /// The same matrix as outer products, one for each column of R.
    fn outer(&self, g: &mut Graph) -> Vec<(Vector, Vector)> {
        let columns = [0, 1, 2].map(|axis| {
            let basis = g.basis(axis);
            let column =
                self.rotations.iter().rev().fold(basis, |v, (slot, inverse)| g.rotate(*slot, *inverse, v));
            let (along, across) = (g.scale(self.identity, column), g.cross(self.skew, column));
            (g.vector_add(along, across), basis)
        });
        columns.into()
    }
}

impl Matrix {
    /// The zero matrix.
    pub fn zero(g: &mut Graph) -> Matrix {
        Matrix { identity: g.zero(), skew: g.zero_vector(), outer: Vec::new(), turned: None }
    }

    /// s I
    pub fn identity(g: &mut Graph, s: Real) -> Matrix {
        Matrix { identity: s, ..Matrix::zero(g) }
    }

    /// `s I + [k]×`
    pub fn skew(g: &mut Graph, s: Real, k: Vector) -> Matrix {
        Matrix { identity: s, skew: k, ..Matrix::zero(g) }
    }

    /// Σ u vᵀ
    pub fn outer(g: &mut Graph, outer: Vec<(Vector, Vector)>) -> Matrix {
        Matrix { outer: merge(g, outer), ..Matrix::zero(g) }
    }

    /// Whether every part is zero.
    pub fn is_zero(&self, g: &Graph) -> bool {
        g.is_zero(self.identity)
            && g.is_zero_vector(self.skew)
            && self.outer.is_empty()
            && self.turned.is_none()
    }

    /// Whether the matrix has no outer products and no turned part.
    pub fn is_simple(&self) -> bool {
        self.outer.is_empty() && self.turned.is_none()
    }

    /// The same matrix with its turned part expanded into outer products.
    pub fn plain(&self, g: &mut Graph) -> Matrix {
        let Some(turned) = &self.turned else { return self.clone() };
        let mut outer = turned.outer(g);
        outer.extend_from_slice(&self.outer);
        Matrix { outer: merge(g, outer), turned: None, ..self.clone() }
    }

    /// Σ coefficient · matrix
    pub fn sum(g: &mut Graph, terms: &[(Exact, &Matrix)]) -> Matrix {
        let mut outer = Vec::new();
        let mut turned: Vec<(Exact, &RotatedBlock)> = Vec::new();
        for (c, m) in terms {
            for &(u, v) in &m.outer {
                outer.push((u, g.vector_sum(vec![(c.clone(), v)])));
            }
            match &m.turned {
                Some(part) if turned.first().is_none_or(|(_, first)| first.rotations == part.rotations) => {
                    turned.push((c.clone(), part));
                }
                Some(part) => {
                    for (u, v) in part.outer(g) {
                        outer.push((u, g.vector_sum(vec![(c.clone(), v)])));
                    }
                }
                None => {}
            }
        }
        Matrix {
            identity: g.sum(Exact::ZERO, terms.iter().map(|(c, m)| (c.clone(), m.identity)).collect()),
            skew: g.vector_sum(terms.iter().map(|(c, m)| (c.clone(), m.skew)).collect()),
            outer: merge(g, outer),
            turned: turned.first().and_then(|(_, first)| {
                let identity =
                    g.sum(Exact::ZERO, turned.iter().map(|(c, t)| (c.clone(), t.identity)).collect());
                let skew = g.vector_sum(turned.iter().map(|(c, t)| (c.clone(), t.skew)).collect());
                part(g, identity, skew, first.rotations.clone())
            }),
        }
    }

    /// x M for a real x
    pub fn scale(&self, g: &mut Graph, x: Real) -> Matrix {
        let outer = self.outer.iter().map(|&(u, v)| (u, g.scale(x, v))).collect();
        let turned = self.turned.as_ref().and_then(|turned| {
            let (identity, skew) = (g.mul(x, turned.identity), g.scale(x, turned.skew));
            part(g, identity, skew, turned.rotations.clone())
        });
        Matrix {
            identity: g.mul(x, self.identity),
            skew: g.scale(x, self.skew),
            outer: merge(g, outer),
            turned,
        }
    }

    /// `[a]× M`
    pub fn cross_left(&self, g: &mut Graph, a: Vector) -> Matrix {
        let along = g.dot(a, self.skew);
        let mut outer = vec![(self.skew, a)];
        outer.extend(self.outer.iter().map(|&(u, v)| (g.cross(a, u), v)));
        let turned = self.turned.as_ref().and_then(|turned| {
            outer.push((turned.skew, turned.unrotate(g, a)));
            let along = g.dot(a, turned.skew);
            let (identity, skew) = (g.neg(along), g.scale(turned.identity, a));
            part(g, identity, skew, turned.rotations.clone())
        });
        Matrix { identity: g.neg(along), skew: g.scale(self.identity, a), outer: merge(g, outer), turned }
    }

    /// gᵀ M as a vector
    pub fn row_times(&self, g: &mut Graph, row: Vector) -> Vector {
        let mut terms =
            vec![(Exact::ONE, g.scale(self.identity, row)), (Exact::ONE, g.cross(row, self.skew))];
        for &(u, v) in &self.outer {
            let along = g.dot(row, u);
            terms.push((Exact::ONE, g.scale(along, v)));
        }
        if let Some(turned) = &self.turned {
            let (along, across) = (g.scale(turned.identity, row), g.cross(row, turned.skew));
            let moved = g.vector_add(along, across);
            terms.push((Exact::ONE, turned.unrotate(g, moved)));
        }
        g.vector_sum(terms)
    }

    /// Mᵀ x
    pub fn transpose_times(&self, g: &mut Graph, x: Vector) -> Vector {
        let mut terms = vec![(Exact::ONE, g.scale(self.identity, x)), (Exact::ONE, g.cross(x, self.skew))];
        for &(u, v) in &self.outer {
            let along = g.dot(u, x);
            terms.push((Exact::ONE, g.scale(along, v)));
        }
        if let Some(turned) = &self.turned {
            let (along, across) = (g.scale(turned.identity, x), g.cross(x, turned.skew));
            let moved = g.vector_add(along, across);
            terms.push((Exact::ONE, turned.unrotate(g, moved)));
        }
        g.vector_sum(terms)
    }

    /// R M for the rotation of a stored quaternion, or of its inverse.
    pub fn rotate_left(&self, g: &mut Graph, quaternion: Slot, inverse: bool) -> Matrix {
        let mut outer: Vec<(Vector, Vector)> =
            self.outer.iter().map(|&(u, v)| (g.rotate(quaternion, inverse, u), v)).collect();
        let mut rotated = Matrix::zero(g);
        if !g.is_zero(self.identity) || !g.is_zero_vector(self.skew) {
            // R (s I + [k]×) = (s I + [R k]×) R
            let skew = g.rotate(quaternion, inverse, self.skew);
            rotated.turned = part(g, self.identity, skew, vec![(quaternion, inverse)]);
        }
        if let Some(turned) = &self.turned {
            let skew = g.rotate(quaternion, inverse, turned.skew);
            let (first, rest) = turned.rotations.split_first().expect("a turned part has rotations");
            let moved = if *first != (quaternion, !inverse) {
                let mut rotations = vec![(quaternion, inverse)];
                rotations.extend_from_slice(&turned.rotations);
                Matrix { turned: part(g, turned.identity, skew, rotations), ..Matrix::zero(g) }
            } else if rest.is_empty() {
                Matrix::skew(g, turned.identity, skew)
            } else {
                Matrix { turned: part(g, turned.identity, skew, rest.to_vec()), ..Matrix::zero(g) }
            };
            rotated = Matrix::sum(g, &[(Exact::ONE, &rotated), (Exact::ONE, &moved)]);
        }
        outer.extend_from_slice(&rotated.outer);
        Matrix { outer: merge(g, outer), ..rotated }
    }
}

/// A turned part, or `None` if it is zero.
fn part(g: &Graph, identity: Real, skew: Vector, rotations: Vec<(Slot, bool)>) -> Option<RotatedBlock> {
    let zero = g.is_zero(identity) && g.is_zero_vector(skew);
    (!zero).then_some(RotatedBlock { identity, skew, rotations })
}

/// `terms` does not split sums of more terms.
const LONGEST_RIGHT: usize = 8;

/// Adds outer products: drops zeros, moves numbers and reals to the right, joins products with a common side.
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
    if !g.formulation.closed {
        let mut open = Vec::with_capacity(products.len());
        for (u, v) in products {
            open.extend(terms(g, v).into_iter().map(|term| (u, term)));
        }
        products = join(g, open, true);
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

/// The terms of a sum, or of a multiple of a sum, if at most `LONGEST_RIGHT`; else the vector itself.
fn terms(g: &mut Graph, v: Vector) -> Vec<Vector> {
    let (scale, inner) = match *g.node(v.index()) {
        Node::Scale(s, inner) => (Some(s), inner),
        _ => (None, v),
    };
    let sum = match g.node(inner.index()) {
        Node::VectorSum(sum) if sum.len() <= LONGEST_RIGHT => sum.clone(),
        _ => return vec![v],
    };
    let mut multiple = |(c, term): (Exact, Vector)| {
        let term = g.vector_sum(vec![(c, term)]);
        scale.map_or(term, |s| g.scale(s, term))
    };
    sum.into_iter().map(&mut multiple).collect()
}

/// Joins products with the same left vector; with `by_right`, the same right vector up to a real factor.
fn join(g: &mut Graph, products: Vec<(Vector, Vector)>, by_right: bool) -> Vec<(Vector, Vector)> {
    let mut groups: BTreeMap<Vector, Vec<(Exact, Vector)>> = BTreeMap::new();
    for (u, v) in products {
        let (key, other) = if by_right { (v, u) } else { (u, v) };
        let (ck, mut key) = g.split_vector(key);
        let (co, mut other) = g.split_vector(other);
        if let Node::Scale(s, inner) = *g.node(key.index()) {
            key = inner;
            other = g.scale(s, other);
        }
        groups.entry(key).or_default().push((&ck * &co, other));
    }
    let mut joined = Vec::new();
    for (key, others) in groups {
        let several = others.len() > 1;
        let sum = g.vector_sum(others);
        if g.is_zero_vector(sum) {
            continue;
        }
        joined.push(if !by_right {
            (key, sum)
        } else if several || g.formulation.bare {
            let (s, sum) = g.split_scale(sum);
            (sum, g.scale(s, key))
        } else {
            (sum, key)
        });
    }
    joined
}
