//! Linear combinations of a few vectors with constant weights: the columns of a deformation gradient F = E W.
//!
//! In: vectors. Out: a triple product of them as det(E W) = det E det W, which is differentiated along the
//! edges instead of through every column. Promise: the product has no cancellation that its factors lack. A
//! sum of squares tr FᵀF is not expanded into Σ (W Wᵀ)ₐᵦ eₐ·eᵦ: on a sliver these terms exceed their sum by
//! the square of the aspect ratio.

use crate::math::exact::Exact;
use crate::vector::{Graph, Node, Real, Vector};
use std::collections::BTreeMap;

/// Σ weight · vector, where the weight of each vector is a sum of coefficients times reals.
type Combination = BTreeMap<Vector, Vec<(Exact, Real)>>;

/// Combinations of more vectors do not change: three vectors span the space.
const SPAN: usize = 3;

/// A weight with more nodes than this is not analysed.
const LARGEST_WEIGHT: usize = 64;

impl Graph {
    /// u·(v×w) of weighted combinations of three vectors as the determinant of the weights times a triple
    /// product.
    pub(super) fn determinant_of_product(&mut self, u: Vector, v: Vector, w: Vector) -> Option<Real> {
        let columns = [self.combination(u)?, self.combination(v)?, self.combination(w)?];
        if columns.iter().filter(|column| column.len() > 1).count() < 2 {
            return None;
        }
        let basis = span(&columns)?;
        let &[x, y, z] = basis.as_slice() else { return Some(self.zero()) };
        let weights = columns.map(|column| [x, y, z].map(|vector| self.weight(&column, vector)));
        let mut terms = Vec::new();
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let first = self.mul(weights[1][j], weights[2][k]);
            let second = self.mul(weights[1][k], weights[2][j]);
            let minor = self.sub(first, second);
            terms.push((Exact::ONE, self.mul(weights[0][i], minor)));
        }
        let weight = self.sum(Exact::ZERO, terms);
        let cross = self.cross(y, z);
        let volume = self.dot(x, cross);
        Some(self.mul(weight, volume))
    }

    /// A vector as a combination of vectors with constant weights, none of which is a number; lets are
    /// expanded.
    fn combination(&self, v: Vector) -> Option<Combination> {
        let mut combination = Combination::new();
        let mut open = vec![(Exact::ONE, None, v)];
        while let Some((c, weight, v)) = open.pop() {
            match (self.vector_at(v), weight) {
                (Node::VectorLet(inner), _) => open.push((c, weight, *inner)),
                (Node::VectorSum(terms), None) if terms.len() <= SPAN => {
                    open.extend(terms.iter().map(|(d, v)| (&c * d, None, *v)));
                }
                (Node::Scale(s, inner), None) if self.is_fixed(*s) => open.push((c, Some(*s), *inner)),
                (_, Some(weight)) => combination.entry(v).or_default().push((c, weight)),
                _ => return None,
            }
        }
        (combination.len() <= SPAN).then_some(combination)
    }

    fn weight(&mut self, combination: &Combination, v: Vector) -> Real {
        self.sum(Exact::ZERO, combination.get(&v).cloned().unwrap_or_default())
    }

    /// Whether a real depends only on parameters and numbers, and on few of them.
    fn is_fixed(&self, real: Real) -> bool {
        let mut open = vec![real.index()];
        let mut seen = 0;
        while let Some(index) = open.pop() {
            seen += 1;
            let node = self.node(index);
            match *node {
                Node::Entry(slot) | Node::Triple(slot) if self.signature.role(slot).is_none() => {}
                Node::Constant(_)
                | Node::Sum(..)
                | Node::Product(_)
                | Node::Dot(..)
                | Node::Component(..)
                | Node::Let(_)
                | Node::VectorSum(_)
                | Node::Scale(..)
                | Node::Cross(..)
                | Node::Pack(_)
                | Node::VectorLet(_) => open.extend(node.operands().into_iter().map(|x| x as usize)),
                _ => return false,
            }
            if seen > LARGEST_WEIGHT {
                return false;
            }
        }
        true
    }
}

/// The vectors in the combinations, if there are few.
fn span(columns: &[Combination]) -> Option<Vec<Vector>> {
    let mut basis: Vec<Vector> = columns.iter().flat_map(BTreeMap::keys).copied().collect();
    basis.sort();
    basis.dedup();
    (basis.len() <= SPAN).then_some(basis)
}
