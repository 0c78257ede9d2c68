//! The generalised-α method: one stage per step, of order two for stiff joints as well.
//!
//! Chung and Hulbert, Journal of Applied Mechanics 60, 1993; with constraints Arnold and Brüls, Multibody
//! System Dynamics 18, 2007; for rotations Brüls and Cardona, Journal of Computational and Nonlinear Dynamics
//! 5, 2010. Forces balance at the end of the step, M v̇₁ = f(x₁, v₁), and a₁ satisfies (1 − αm) a₁ + αm a₀ =
//! (1 − αf) v̇₁ + αf v̇₀:
//!
//! v₁ = v₀ + h ((1 − γ) a₀ + γ a₁), x₁ = x₀ ⊕ (h v₀ + h² ((½ − β) a₀ + β a₁)).
//!
//! The bodies store both rates, a and v̇. If the rates are missing or invalid, or the island is solved in
//! parts, the step is one of SDIRK2.

use super::implicit::SDIRK;
use super::{BlockSize, Model, Outcome, Stepper};
use crate::state::Store;
use crate::system::assemble::Assembly;
use nalgebra::{RealField, SVector, Vector6, convert};

/// The spectral radius at infinite frequency.
const RHO: f64 = 0.6;

/// The coefficients with this radius that damp low frequencies least; αm < αf ≤ ½.
const ALPHA_M: f64 = (2.0 * RHO - 1.0) / (RHO + 1.0);
const ALPHA_F: f64 = RHO / (RHO + 1.0);
const GAMMA: f64 = 0.5 + ALPHA_F - ALPHA_M;
const BETA: f64 = 0.25 * (GAMMA + 0.5) * (GAMMA + 0.5);

impl<R: RealField + Copy, const D: usize> Stepper<'_, R, D>
where
    Assembly<R, D>: BlockSize<R>,
{
    pub(super) fn generalized_alpha(&mut self, h: R) -> Option<Outcome<R>> {
        let number = convert::<f64, R>;
        if !self.warm {
            let outcome = self.sdirk2(h)?;
            self.model.find_rates(h * number(SDIRK));
            let [auxiliary, rate] = &mut self.model.rates;
            auxiliary.clone_from(rate);
            return Some(outcome);
        }
        self.model.gather_rates(self.store);
        // a₁ = share · v̇₁ + known.
        let share = (1.0 - ALPHA_F) / (1.0 - ALPHA_M);
        let (step, stiffness) = (h * number(GAMMA * share), h * h * number(BETA * share));
        // The change of the pose per change of v₁.
        let lever = stiffness / step;
        let Model { start, velocity, rates: [auxiliary, rates], stages: [_, [origin, before, ..]], .. } =
            &mut *self.model;
        origin.clear();
        before.clear();
        for (((velocity, v0), a0), rate) in velocity.iter_mut().zip(start).zip(auxiliary).zip(rates) {
            // The part of a₁ that does not depend on v̇₁; replaces a₀.
            let known = (*rate * number(ALPHA_F) - *a0 * number(ALPHA_M)) / number(1.0 - ALPHA_M);
            let speed = *v0 + (*a0 * number(1.0 - GAMMA) + known * number(GAMMA)) * h;
            let way = (*v0 + (*a0 * number(0.5 - BETA) + known * number(BETA)) * h) * h;
            origin.push(speed);
            before.push(way - speed * lever);
            *velocity = speed + *rate * step;
            *a0 = known;
        }
        let residual = self.stage(h, step, stiffness, |before, v| *before + *v * lever)?;
        self.set(h);
        self.model.find_rates(step);
        let [auxiliary, rates] = &mut self.model.rates;
        for (a, rate) in auxiliary.iter_mut().zip(rates) {
            *a += *rate * number(share);
        }
        Some(Outcome { residual, error: None, work: None })
    }
}

impl<R: RealField + Copy, const D: usize> Model<R, D> {
    /// Computes v̇ of the last stage.
    fn find_rates(&mut self, step: R) {
        let Model { velocity, rates: [_, rates], stages: [_, [origin, ..]], .. } = self;
        rates.clear();
        rates.extend(velocity.iter().zip(origin).map(|(v, origin)| (*v - *origin) / step));
    }

    fn gather_rates(&mut self, store: &Store<R>) {
        let Model { assembly, rates, start, .. } = self;
        for rates in rates.iter_mut() {
            rates.resize(start.len(), SVector::zeros());
        }
        for (members, nodes) in store.members.iter().zip(&assembly.nodes) {
            for (member, node) in members.iter().zip(nodes) {
                let Some(node) = *node else { continue };
                for (rates, kept) in rates.iter_mut().zip(&member.rates) {
                    rates[node] = SVector::from_fn(|i, _| kept[i]);
                }
            }
        }
    }

    /// Stores the rates at the end of an accepted step in the bodies.
    pub(crate) fn keep_rates(&self, store: &mut Store<R>) {
        for (members, nodes) in store.members.iter_mut().zip(&self.assembly.nodes) {
            for (member, node) in members.iter_mut().zip(nodes) {
                let Some(node) = *node else { continue };
                member.rates = self
                    .rates
                    .each_ref()
                    .map(|rates| Vector6::from_fn(|i, _| if i < D { rates[node][i] } else { R::zero() }));
            }
        }
    }
}
