//! The explicit methods: symplectic Euler and the classical Runge-Kutta method.
//!
//! Input: the bodies at the start of a step and its length h. Output: the bodies at its end. No linear system
//! is solved, so the residual is zero and no method fails; stability limits h.

use super::{BlockSize, Model, Outcome, Stepper, each_mass};
use crate::system::assemble::{Assembly, Wants};
use crate::system::inertia::{Frame, add_angular, add_linear, angular, linear};
use nalgebra::{RealField, SVector, convert};

impl<R: RealField + Copy, const D: usize> Stepper<'_, R, D>
where
    Assembly<R, D>: BlockSize<R>,
{
    pub(super) fn symplectic_euler(&mut self, h: R) -> Option<Outcome<R>> {
        self.accelerate();
        let Model { assembly, velocity, pose, .. } = &mut *self.model;
        for ((v, x), a) in velocity.iter_mut().zip(pose).zip(&assembly.system.rhs) {
            *v += *a * h;
            *x = *v * h;
        }
        self.set(h);
        Some(Outcome { residual: R::zero(), error: None })
    }

    pub(super) fn runge_kutta(&mut self, h: R) -> Option<Outcome<R>> {
        let number = convert::<f64, R>;
        let nodes = self.model.start.len();
        let mut total = std::mem::take(&mut self.model.change);
        for sum in &mut total {
            sum.clear();
            sum.resize(nodes, SVector::zeros());
        }
        for (weight, next) in [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)] {
            self.accelerate();
            let (weight, next) = (number(weight / 6.0) * h, number(next) * h);
            let Model { assembly, start, velocity, pose, .. } = &mut *self.model;
            for node in 0..nodes {
                let rate = pose_rate(&pose[node], &velocity[node]);
                let acceleration = assembly.system.rhs[node];
                total[0][node] += rate * weight;
                total[1][node] += acceleration * weight;
                pose[node] = rate * next;
                velocity[node] = start[node] + acceleration * next;
            }
            self.set(next);
        }
        let Model { start, velocity, pose, .. } = &mut *self.model;
        for node in 0..nodes {
            pose[node] = total[0][node];
            velocity[node] = start[node] + total[1][node];
        }
        self.model.change = total;
        self.set(h);
        Some(Outcome { residual: R::zero(), error: None })
    }

    /// Computes accelerations at the present state into the right-hand side.
    fn accelerate(&mut self) {
        self.assemble(R::zero(), R::zero(), Wants::default());
        let Assembly { system, force, nodes, .. } = &mut self.model.assembly;
        let rhs = &mut system.rhs;
        each_mass(self.store, nodes, |node, mass, body| {
            rhs[node] = SVector::zeros();
            add_linear(&mut rhs[node], linear(&force[node]) / mass);
            if let Some((index, moments)) = body {
                let frame = Frame::new(&self.store.rigid[index], moments);
                add_angular(&mut rhs[node], frame.accelerate(&angular(&force[node])));
            }
        });
    }
}

/// δ̇ of a pose: v, and dexp⁻¹_θ(ω) = ω − ½ θ×ω + (1 − |θ|/2 cot(|θ|/2)) / |θ|² θ×(θ×ω).
pub(super) fn pose_rate<R: RealField + Copy, const D: usize>(
    pose: &SVector<R, D>,
    velocity: &SVector<R, D>,
) -> SVector<R, D> {
    let number = convert::<f64, R>;
    let (turn, spin) = (angular(pose), angular(velocity));
    let square = turn.norm_squared();
    // For smaller angles the series is exact to rounding: its next term is |θ|⁴/30240.
    let factor = if square < number(1e-4) {
        number(1.0 / 12.0) + square * number(1.0 / 720.0)
    } else {
        let half = square.sqrt() * number(0.5);
        (R::one() - half / half.tan()) / square
    };
    let across = turn.cross(&spin);
    let mut rate = *velocity;
    add_angular(&mut rate, turn.cross(&across) * factor - across * number(0.5));
    rate
}
