//! The largest stable step in a small scene: the last body hangs, all others are fixed.
//!
//! In: a model. Out: for each solver, the largest step at which energy does not grow. The scene: a body of 1
//! kg with moment 0.1 kg m² about any axis starts at rest near a satisfied constraint and falls at 9.81 m/s².
//! The integrator is linearly implicit Euler, (M − h ∂F/∂V − h² K) δv = h (F + h K v), with the function's
//! derivatives.

use crate::lint::GAP;
use crate::lint::measure::gauss_newton;
use crate::lint::model::{Model, Response};
use crate::math::random::Random;
use crate::model::bodies::Role;
use crate::vector::definition::Law;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The stiffness of constraints, N/m or N·m/rad.
pub const STIFFNESS: f64 = 1e4;
/// The tested multiples of critical damping; an energy has no damping.
pub const DAMPING: [(&str, f64); 3] =
    [("undamped", 0.0), ("critical damping", 1.0), ("100 × critical damping", 100.0)];

const MASS: f64 = 1.0;
const MOMENT: f64 = 0.1;
const GRAVITY: f64 = 9.81;
/// The largest tested step, s, and the number of steps that halving tests.
const LARGEST: f64 = 0.5;
const HALVINGS: i32 = 11;
/// The smallest tested step, s.
pub(super) const SMALLEST: f64 = LARGEST / (1 << (HALVINGS - 1)) as f64;
/// The number of smaller steps that must also be stable.
const BELOW: i32 = 2;
const BISECTIONS: usize = 3;
/// The duration of a run, s, and its smallest number of steps.
const TIME: f64 = 1.0;
const STEPS: usize = 60;
/// The tolerated growth of energy, relative to its scale.
const GROWTH: f64 = 0.01;
const STARTS: usize = 3;

/// The largest stable steps of a function, s, at each damping; `None` if no tested step is stable.
#[derive(Clone, Debug)]
pub struct Steps {
    /// With ∂F/∂X.
    pub full: Vec<Option<f64>>,
    /// With −ks JᵀJ instead; for constraints.
    pub gauss_newton: Vec<Option<f64>>,
}

pub(super) fn largest_steps(model: &Model) -> Option<Steps> {
    let scene = Scene::new(model)?;
    let damping = if model.is_constraint() { &DAMPING[..] } else { &DAMPING[..1] };
    let steps =
        |by_rows: bool| damping.iter().map(|(_, factor)| scene.largest(by_rows, *factor)).collect::<Vec<_>>();
    let full = steps(false);
    Some(Steps { full, gauss_newton: if model.is_constraint() { steps(true) } else { Vec::new() } })
}

struct Scene<'m, 'a> {
    model: &'m Model<'a>,
    /// The coordinates of the moving body.
    free: Range<usize>,
    starts: Vec<Vec<f64>>,
    mass: DVector<f64>,
}

impl<'m, 'a> Scene<'m, 'a> {
    fn new(model: &'m Model<'a>) -> Option<Scene<'m, 'a>> {
        let pose = &model.layout.pose;
        let last = pose.last()?.body;
        let free = pose.iter().position(|c| c.body == last)?..pose.len();
        let mut random = Random::new(7);
        let mut starts = Vec::new();
        for drawn in model.draw(8 * STARTS, 3) {
            let rest = model.rest(&drawn);
            let start = if model.is_constraint() {
                let Some(satisfied) = model.satisfied(&rest, &free) else { continue };
                model.moved(&satisfied, &(model.direction(&mut random, &free) * (0.1 * GAP)))
            } else {
                rest
            };
            if starts.len() < STARTS && model.at(&start).is_finite() {
                starts.push(start);
            }
        }
        let inertia = |k: usize| if pose[k].role == Role::Orientation { MOMENT } else { MASS };
        let mass = DVector::from_iterator(free.len(), free.clone().map(inertia));
        (!starts.is_empty()).then_some(Scene { model, free, starts, mass })
    }

    /// Halves the step until it and the next halvings are stable; then bisects up to the last unstable step.
    fn largest(&self, by_rows: bool, damping: f64) -> Option<f64> {
        let mut runs: Vec<(f64, bool)> = Vec::new();
        for halving in 0..HALVINGS {
            let h = LARGEST / f64::from(1 << halving);
            runs.push((h, self.is_stable(by_rows, damping, h)));
            let stable = runs.iter().rev().take_while(|(_, stable)| *stable).count() as i32;
            if stable > BELOW {
                break;
            }
        }
        let first = runs.iter().rposition(|(_, stable)| !stable).map_or(0, |last| last + 1);
        let (mut low, _) = *runs.get(first)?;
        if let Some(before) = first.checked_sub(1) {
            let mut high = runs[before].0;
            for _ in 0..BISECTIONS {
                let middle = (low * high).sqrt();
                *(if self.is_stable(by_rows, damping, middle) { &mut low } else { &mut high }) = middle;
            }
        }
        Some(low)
    }

    fn is_stable(&self, by_rows: bool, damping: f64, h: f64) -> bool {
        self.starts.iter().all(|start| self.runs(start, by_rows, damping, h))
    }

    /// Critical damping, 2 √(ks / w), with w the largest diagonal entry of J M⁻¹ Jᵀ.
    fn critical(&self, start: &[f64]) -> f64 {
        let jacobian = self.model.at(start).jacobian.columns(self.free.start, self.free.len()).into_owned();
        let inverse = DMatrix::from_diagonal(&self.mass.map(f64::recip));
        let response = (&jacobian * inverse * jacobian.transpose()).diagonal();
        if response.max() > 0.0 { 2.0 * (STIFFNESS / response.max()).sqrt() } else { 0.0 }
    }

    fn runs(&self, start: &[f64], by_rows: bool, damping: f64, h: f64) -> bool {
        let model = self.model;
        let mut state = start.to_vec();
        if model.is_constraint() {
            model.set_gains(&mut state, STIFFNESS, damping * self.critical(start));
        }
        let mut velocity = DVector::zeros(self.free.len());
        let mut at = model.at(&state);
        let first = self.energy(&state, &at, &velocity);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..((TIME / h) as usize).max(STEPS) {
            let block = |matrix: &DMatrix<f64>| {
                matrix
                    .view((self.free.start, self.free.start), (self.free.len(), self.free.len()))
                    .into_owned()
            };
            let k = if by_rows { block(&gauss_newton(model, &at, STIFFNESS)) } else { block(&at.dfdx) };
            let matrix = DMatrix::from_diagonal(&self.mass) - block(&at.dfdv) * h - &k * (h * h);
            let mut force = at.force.rows(self.free.start, self.free.len()).into_owned();
            force[2] -= MASS * GRAVITY;
            let Some(change) = matrix.lu().solve(&((force + k * &velocity * h) * h)) else { return false };
            velocity += change;
            let mut delta = DVector::zeros(model.dofs());
            delta.rows_mut(self.free.start, self.free.len()).copy_from(&(&velocity * h));
            state = model.moved(&state, &delta);
            let mut all = DVector::zeros(model.dofs());
            all.rows_mut(self.free.start, self.free.len()).copy_from(&velocity);
            model.set_velocity(&mut state, &all);
            at = model.at(&state);
            let (potential, moving) = self.energy(&state, &at, &velocity);
            (low, high) = (low.min(moving), high.max(moving));
            let scale = (high - low).max(MASS * GRAVITY);
            let energy = potential + moving;
            if !energy.is_finite() || !at.is_finite() || energy - first.0 - first.1 > GROWTH * scale {
                return false;
            }
        }
        true
    }

    /// The potential energy of gravity, and the kinetic plus elastic energy.
    fn energy(&self, state: &[f64], at: &Response, velocity: &DVector<f64>) -> (f64, f64) {
        let height = state[self.model.layout.pose[self.free.start].start + 2];
        let kinetic = 0.5 * velocity.component_mul(velocity).dot(&self.mass);
        let elastic = match self.model.definition.law {
            Law::Constraint { unilateral, .. } => {
                let stretched = at.value.iter().filter(|c| !unilateral || **c < 0.0);
                0.5 * STIFFNESS * stretched.map(|c| c * c).sum::<f64>()
            }
            _ => at.value.sum(),
        };
        (MASS * GRAVITY * height, kinetic + elastic)
    }
}
