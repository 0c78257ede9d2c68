//! Iterative solvers, preconditioned by the diagonal blocks.
//!
//! Conjugate gradients require a symmetric system; the other methods do not. CGS and BiCG follow D'Amora et
//! al., IBM Systems Journal 45(1), 2006, with signs corrected: r −= α A p, and β from the new residuals. A
//! division by zero or a result that is not finite is a breakdown, which the solver reports.

use crate::system::block::Block;
use crate::system::sparse::System;
use nalgebra::{RealField, SVector, convert};

/// A method for the linear system of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Solver {
    /// Block elimination if the fill is small or after a breakdown; else stabilised biconjugate gradients.
    #[default]
    Automatic,
    /// Block elimination.
    Direct,
    /// Conjugate gradients, Hestenes and Stiefel 1952; requires a symmetric system.
    ConjugateGradients,
    /// Stabilised biconjugate gradients, van der Vorst 1992.
    BiCgStab,
    /// Conjugate gradients squared, Sonneveld 1989.
    Cgs,
    /// Biconjugate gradients, Fletcher 1976.
    BiCg,
}

/// Vectors of the iterations, reused in every step.
#[derive(Clone, Debug)]
pub(crate) struct Workspace<R: RealField, const D: usize> {
    x: Vec<SVector<R, D>>,
    vectors: [Vec<SVector<R, D>>; 8],
}

impl<R: RealField, const D: usize> Default for Workspace<R, D> {
    fn default() -> Workspace<R, D> {
        Workspace { x: Vec::new(), vectors: Default::default() }
    }
}

/// The limit on iterations, as a multiple of the number of unknowns.
const PATIENCE: usize = 4;

impl<R: RealField + Copy, const D: usize> System<R, D> {
    /// Replaces the right-hand side by the solution; returns the iterations, or `None` after a breakdown.
    pub(crate) fn iterate(
        &mut self,
        method: Solver,
        tolerance: R,
        space: &mut Workspace<R, D>,
    ) -> Option<usize> {
        let nodes = self.nodes();
        space.x.clear();
        space.x.resize(nodes, SVector::zeros());
        for vector in &mut space.vectors {
            vector.clear();
            vector.resize(nodes, SVector::zeros());
        }
        self.factors[..nodes].copy_from_slice(&self.blocks[..nodes]);
        self.factors[..nodes].iter_mut().for_each(Block::factor);
        let goal = tolerance * norm(&self.rhs);
        let iterations = match method {
            Solver::ConjugateGradients => self.conjugate_gradients(goal, space),
            Solver::Cgs => self.cgs(goal, space),
            Solver::BiCg => self.bicg(goal, space),
            _ => self.bicgstab(goal, space),
        }?;
        self.keep_rhs();
        self.rhs.copy_from_slice(&space.x);
        Some(iterations)
    }

    /// y = P⁻¹ x, P the diagonal blocks.
    fn precondition(&self, x: &[SVector<R, D>], y: &mut [SVector<R, D>]) {
        for ((y, x), lu) in y.iter_mut().zip(x).zip(&self.factors) {
            *y = *x;
            lu.solve(y);
        }
    }

    /// y = P⁻ᵀ x: solves with Uᵀ, then with Lᵀ.
    fn precondition_transposed(&self, x: &[SVector<R, D>], y: &mut [SVector<R, D>]) {
        for ((y, x), lu) in y.iter_mut().zip(x).zip(&self.factors) {
            *y = *x;
            for k in 0..D {
                y[k] *= lu.0[k][k];
                let value = y[k];
                for i in k + 1..D {
                    y[i] -= lu.0[k][i] * value;
                }
            }
            for k in (0..D).rev() {
                let value = y[k];
                for i in 0..k {
                    y[i] -= lu.0[k][i] * value;
                }
            }
        }
    }

    fn limit(&self) -> usize {
        PATIENCE * D * self.nodes() + 10
    }

    /// Repeats `step` until the residual is small; returns how often, or `None` at the limit or a breakdown.
    fn repeat(
        &self,
        goal: R,
        r: &mut [SVector<R, D>],
        mut step: impl FnMut(&mut [SVector<R, D>]) -> Option<()>,
    ) -> Option<usize> {
        r.copy_from_slice(&self.rhs);
        for iteration in 0..self.limit() {
            if norm(r) <= goal {
                return Some(iteration);
            }
            step(r)?;
        }
        None
    }

    fn conjugate_gradients(&self, goal: R, space: &mut Workspace<R, D>) -> Option<usize> {
        let Workspace { x, vectors: [r, z, p, q, ..] } = space;
        let mut old = None;
        self.repeat(goal, r, |r| {
            self.precondition(r, z);
            let rho = dot(r, z);
            let beta = growth(rho, old)?;
            combine(p, |k, p| z[k] + p * beta);
            self.multiply(p, q);
            // Without positive curvature, the system is not positive definite.
            let curvature = dot(p, q);
            if curvature <= R::zero() {
                return None;
            }
            let alpha = ratio(rho, curvature)?;
            combine(x, |k, x| x + p[k] * alpha);
            combine(r, |k, r| r - q[k] * alpha);
            old = Some(rho);
            Some(())
        })
    }

    fn bicgstab(&self, goal: R, space: &mut Workspace<R, D>) -> Option<usize> {
        let Workspace { x, vectors: [r, shadow, p, v, s, t, ph, sh] } = space;
        shadow.copy_from_slice(&self.rhs);
        let (mut old, mut alpha, mut omega) = (None, R::one(), R::one());
        self.repeat(goal, r, |r| {
            let rho = dot(shadow, r);
            let beta = growth(rho, old)? * ratio(alpha, omega)?;
            combine(p, |k, p| r[k] + (p - v[k] * omega) * beta);
            self.precondition(p, ph);
            self.multiply(ph, v);
            alpha = ratio(rho, dot(shadow, v))?;
            combine(s, |k, _| r[k] - v[k] * alpha);
            combine(x, |k, x| x + ph[k] * alpha);
            if norm(s) <= goal {
                r.copy_from_slice(s);
                return Some(());
            }
            self.precondition(s, sh);
            self.multiply(sh, t);
            omega = ratio(dot(t, s), dot(t, t))?;
            combine(x, |k, x| x + sh[k] * omega);
            combine(r, |k, _| s[k] - t[k] * omega);
            old = Some(rho);
            Some(())
        })
    }

    fn cgs(&self, goal: R, space: &mut Workspace<R, D>) -> Option<usize> {
        let Workspace { x, vectors: [r, shadow, p, q, u, uh, v, t] } = space;
        shadow.copy_from_slice(&self.rhs);
        let mut old = None;
        self.repeat(goal, r, |r| {
            let rho = dot(shadow, r);
            let beta = growth(rho, old)?;
            combine(u, |k, _| r[k] + q[k] * beta);
            combine(p, |k, p| u[k] + (q[k] + p * beta) * beta);
            self.precondition(p, uh);
            self.multiply(uh, v);
            let alpha = ratio(rho, dot(shadow, v))?;
            combine(q, |k, _| u[k] - v[k] * alpha);
            combine(t, |k, _| u[k] + q[k]);
            self.precondition(t, uh);
            combine(x, |k, x| x + uh[k] * alpha);
            self.multiply(uh, t);
            combine(r, |k, r| r - t[k] * alpha);
            old = Some(rho);
            Some(())
        })
    }

    fn bicg(&self, goal: R, space: &mut Workspace<R, D>) -> Option<usize> {
        let Workspace { x, vectors: [r, shadow, p, ps, z, zs, q, qs] } = space;
        shadow.copy_from_slice(&self.rhs);
        let mut old = None;
        self.repeat(goal, r, |r| {
            self.precondition(r, z);
            self.precondition_transposed(shadow, zs);
            let rho = dot(z, shadow);
            let beta = growth(rho, old)?;
            combine(p, |k, p| z[k] + p * beta);
            combine(ps, |k, p| zs[k] + p * beta);
            self.multiply(p, q);
            self.multiply_transposed(ps, qs);
            let alpha = ratio(rho, dot(ps, q))?;
            combine(x, |k, x| x + p[k] * alpha);
            combine(r, |k, r| r - q[k] * alpha);
            combine(shadow, |k, r| r - qs[k] * alpha);
            old = Some(rho);
            Some(())
        })
    }
}

/// Replaces each entry of a vector by a function of its index and value.
fn combine<R: RealField + Copy, const D: usize>(
    vector: &mut [SVector<R, D>],
    entry: impl Fn(usize, SVector<R, D>) -> SVector<R, D>,
) {
    for (k, slot) in vector.iter_mut().enumerate() {
        *slot = entry(k, *slot);
    }
}

fn dot<R: RealField + Copy, const D: usize>(a: &[SVector<R, D>], b: &[SVector<R, D>]) -> R {
    a.iter().zip(b).fold(R::zero(), |sum, (a, b)| sum + a.dot(b))
}

fn norm<R: RealField + Copy, const D: usize>(a: &[SVector<R, D>]) -> R {
    dot(a, a).sqrt()
}

/// a / b; `None` for a breakdown: b is 0, or the quotient is not finite.
fn ratio<R: RealField + Copy>(a: R, b: R) -> Option<R> {
    let ratio = a / b;
    (ratio.is_finite() && b.abs() > convert::<f64, R>(f64::MIN_POSITIVE)).then_some(ratio)
}

/// β = ρ / previous ρ; zero in the first iteration.
fn growth<R: RealField + Copy>(rho: R, old: Option<R>) -> Option<R> {
    old.map_or(Some(R::zero()), |old| ratio(rho, old))
}
