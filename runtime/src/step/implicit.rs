//! The linearly implicit Euler method and SDIRK2, and the implicit stage that other methods share.
//!
//! Input: the bodies at the start of a step and its length h. Output: the bodies at its end, with the largest
//! relative residual of the linear systems. A method returns `None` if a solver broke down.

use super::{BlockSize, Model, Outcome, Stepper};
use crate::system::assemble::{Assembly, Wants};
use crate::system::batch::has_rows;
use crate::system::inertia::{add_angular, angular};
use nalgebra::{RealField, SVector, convert};
use std::time::Instant;

/// γ of SDIRK.
pub(super) const SDIRK: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// The largest number of linearisations of a stage.
const LINEARISATIONS: usize = 3;

/// The rotation, rad, above which a stage is linearised again. At this rotation the error opens a joint by
/// 1e-4 of its arm, which the next step corrects.
const FAR: f64 = 0.016;

/// The same, and the most linearisations, with rigid rows, which no stiffness lets give way.
const CLOSED: f64 = 1e-4;
const LINEARISATIONS_OF_ROWS: usize = 8;

/// The same for an energy, whose derivatives contain the full error.
const NEAR: f64 = 0.002;

impl<R: RealField + Copy, const D: usize> Stepper<'_, R, D>
where
    Assembly<R, D>: BlockSize<R>,
{
    pub(super) fn implicit_euler(&mut self, h: R, exact: bool) -> Option<Outcome<R>> {
        self.assemble(h, h * h, Wants { matrix: true, exact, drift: true, ..Wants::default() });
        let Assembly { system, force, drift, .. } = &mut self.model.assembly;
        for ((b, f), kv) in system.rhs.iter_mut().zip(force).zip(drift) {
            *b = (*f + *kv * h) * h;
        }
        self.solve()?;
        let residual = self.residual();
        let Model { assembly, velocity, pose, .. } = &mut *self.model;
        for ((v, x), change) in velocity.iter_mut().zip(pose).zip(&assembly.system.rhs) {
            *v += *change;
            *x = *v * h;
        }
        self.set(h);
        Some(Outcome { residual, error: None, work: None })
    }

    /// Alexander's method: v₁ = v₀ + hγ a₁, v₂ = v₀ + h(1−γ) a₁ + hγ a₂, and likewise for poses. The second
    /// pose increment θ includes dexp⁻¹: θ = h(1−γ) ω₁ + hγ (ω₂ − ½ θ × ω₂).
    ///
    /// The initial guess of the first stage is v₀ and x₀ ⊕ hγ v₀, that of the second v₁ and x₀ ⊕ h v₁.
    pub(super) fn sdirk2(&mut self, h: R) -> Option<Outcome<R>> {
        let gamma = convert::<f64, R>(SDIRK);
        let step = h * gamma;
        let Model { start, stages: [_, [origin, middle, ..]], .. } = &mut *self.model;
        origin.clone_from(start);
        middle.clone_from(start);
        let first = self.stage(step, step, step * step, |_, v| v * step)?;
        let Model { start, velocity, stages: [_, [origin, middle, ..]], .. } = &mut *self.model;
        middle.clone_from(velocity);
        let share = (R::one() - gamma) / gamma;
        for ((origin, v0), v1) in origin.iter_mut().zip(start).zip(middle) {
            *origin = *v0 + (*v1 - *v0) * share;
        }
        let second = self.stage(h, step, step * step, |v1, v2| {
            let mut x = v1 * (h - step) + v2 * step;
            let correction = angular(&x).cross(&angular(v2)) * (step * convert::<f64, R>(0.5));
            add_angular(&mut x, -correction);
            x
        })?;
        self.set(h);
        Some(Outcome { residual: first.max(second), error: None, work: None })
    }

    /// Solves one stage: v = o + a `step` with o = `stages[1][0]`, and the pose `at(stages[1][1], v)`;
    /// returns the residual. `velocity` contains the initial guess; `stiffness` / `step` is the change of the
    /// pose per change of v.
    ///
    /// The stage is linearised at the guess. For forces with an arm the error is quadratic in the rotation
    /// from the guess; after a large rotation the stage is linearised again at the solution.
    pub(super) fn stage(
        &mut self,
        time: R,
        step: R,
        stiffness: R,
        at: impl Fn(&SVector<R, D>, &SVector<R, D>) -> SVector<R, D>,
    ) -> Option<R> {
        let Model { velocity, pose, stages: [_, [_, before, ..]], .. } = &mut *self.model;
        for ((x, v), before) in pose.iter_mut().zip(velocity).zip(before) {
            *x = at(before, v);
        }
        let held = self.batches.iter().any(|batch| batch.has_multipliers());
        let far = if held && !self.batches.iter().any(|batch| batch.is_energy()) { FAR } else { NEAR };
        let has_rows = has_rows(self.batches);
        let (far, linearisations) =
            if has_rows { (CLOSED, LINEARISATIONS_OF_ROWS) } else { (far, LINEARISATIONS) };
        for left in (0..linearisations).rev() {
            self.set(time);
            let Model { assembly, velocity, stages: [_, [origin, ..]], .. } = &mut *self.model;
            for ((momentum, v), origin) in assembly.momentum.iter_mut().zip(velocity).zip(origin) {
                *momentum = *v - *origin;
            }
            let wants = Wants { matrix: true, exact: true, momentum: true, held, ..Wants::default() };
            self.assemble(step, stiffness, wants);
            let Assembly { system, force, momentum, .. } = &mut self.model.assembly;
            for ((b, f), momentum) in system.rhs.iter_mut().zip(force).zip(momentum) {
                *b = *f * step - *momentum;
            }
            self.solve()?;
            for batch in self.batches.iter_mut() {
                batch.predict(self.model.assembly.sums());
            }
            let Model { assembly, velocity, pose, stages: [_, [_, before, ..]], .. } = &mut *self.model;
            let mut turned = R::zero();
            for ((((x, v), change), before), is_joint) in
                pose.iter_mut().zip(velocity).zip(&assembly.system.rhs).zip(before).zip(&assembly.is_joint)
            {
                if *is_joint {
                    continue;
                }
                *v += *change;
                turned = turned.max(angular(change).norm_squared());
                *x = at(before, v);
            }
            if left == 0 || turned.sqrt() * (stiffness / step) <= convert(far) {
                break;
            }
        }
        // Earlier solutions are only guesses.
        Some(self.residual())
    }

    /// The relative residual of the last solution.
    fn residual(&mut self) -> R {
        let timer = Instant::now();
        let residual = self.model.assembly.system.residual();
        self.report.solve += timer.elapsed();
        residual
    }
}
