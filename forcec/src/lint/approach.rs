//! Behaviour of a function near its singular places.
//!
//! In: a model, and a singular place that range analysis could not exclude. Out: the distance to the place
//! where the constraint is satisfied, and the growth of force, stiffness and damping near the place.

use crate::lint::model::{Model, median};
use crate::vector::definition::Singular;
use crate::verify::source::Source;
use nalgebra::DVector;

/// Powers p of the growth 1/dᵖ near a singular place, d the distance of the operand from its singular value.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// The power of F without damping.
    pub force: f64,
    /// The power of ∂F/∂X without damping.
    pub stiffness: f64,
    /// The power of ∂F/∂V; negative if damping vanishes.
    pub damping: Option<f64>,
    /// The power of the damping's contribution to ∂F/∂X.
    pub damped_stiffness: Option<f64>,
}

/// Measurements at a singular place.
#[derive(Clone, Debug)]
pub struct Approach {
    /// The operand's distance from its singular value within [`crate::lint::GAP`] of a satisfied constraint.
    pub satisfied: Option<f64>,
    /// The growth; `None` if no motion leads to the place, or nothing acts there.
    pub growth: Option<Growth>,
}

/// The distances between which growth is measured.
const NEAR: [f64; 2] = [1e-3, 1e-5];
const STARTS: usize = 5;
const ITERATIONS: usize = 80;

pub(super) fn approach(model: &Model, place: &Singular, drawn: &[Vec<f64>], near: &[Vec<f64>]) -> Approach {
    let operand = Operand {
        model,
        place,
        source: Source::new(&model.definition.graph, &model.layout, [place.operand.index()]),
    };
    let satisfied = median(near.iter().map(|state| operand.distance(state).0).collect());
    let sizes = |state: &[f64]| {
        let mut state = state.to_vec();
        let undamped = model.at(&state);
        model.set_gains(&mut state, 1.0, 1.0);
        let damped = model.at(&state);
        let added = (&damped.dfdx - &undamped.dfdx).norm();
        [undamped.force.norm(), undamped.dfdx.norm(), damped.dfdv.norm(), added]
    };
    let mut powers: [Vec<f64>; 4] = Default::default();
    for start in drawn {
        if powers[0].len() == STARTS {
            break;
        }
        let Some(far) = operand.reach(start, NEAR[0]) else { continue };
        let Some(close) = operand.reach(&far, NEAR[1]) else { continue };
        let ratio = operand.distance(&far).0 / operand.distance(&close).0;
        let (far, close) = (sizes(&far), sizes(&close));
        // A row that does not push has no size to compare.
        if far.iter().chain(&close).all(|size| *size == 0.0) {
            continue;
        }
        for ((powers, far), close) in powers.iter_mut().zip(far).zip(close) {
            let power = (close / far).ln() / ratio.ln();
            // A size that is zero at both distances does not grow.
            powers.extend(Some(if far == 0.0 && close == 0.0 { 0.0 } else { power }).filter(|p| !p.is_nan()));
        }
    }
    let has_damping = drawn.iter().any(|state| sizes(state)[2] > 0.0);
    let [force, stiffness, damping, added] = powers.map(median);
    let growth = force.zip(stiffness).map(|(force, stiffness)| Growth {
        force,
        stiffness,
        damping: damping.filter(|_| has_damping),
        damped_stiffness: added.filter(|_| has_damping && model.is_constraint()),
    });
    Approach { satisfied, growth }
}

struct Operand<'m, 'a> {
    model: &'m Model<'a>,
    place: &'m Singular,
    source: Source<'m, f64>,
}

impl Operand<'_, '_> {
    /// The distance of the operand from the nearest singular value, and the side.
    fn distance(&self, state: &[f64]) -> (f64, f64) {
        let values = self.source.evaluate(state);
        let value = *self.source.get(&values, self.place.operand.index()).real();
        let apart = self.place.ends.iter().map(|end| value - end);
        let nearest = apart.min_by(|x, y| x.abs().total_cmp(&y.abs())).unwrap_or(f64::NAN);
        (nearest.abs(), nearest.signum())
    }

    /// A state at about this distance, by Newton's method along the poses; `None` if the method fails.
    fn reach(&self, start: &[f64], target: f64) -> Option<Vec<f64>> {
        let n = self.model.dofs();
        let mut state = start.to_vec();
        for _ in 0..ITERATIONS {
            let (distance, side) = self.distance(&state);
            if !distance.is_finite() {
                return None;
            }
            if (0.5..2.0).contains(&(distance / target)) {
                return Some(state);
            }
            let step = (1e-3 * distance).clamp(1e-9, 1e-4);
            let slope = DVector::from_fn(n, |k, _| {
                let mut delta = DVector::zeros(n);
                delta[k] = step;
                let value = |state: Vec<f64>| {
                    let (distance, of) = self.distance(&state);
                    distance * of * side
                };
                (value(self.model.moved(&state, &delta)) - value(self.model.moved(&state, &-delta)))
                    / (2.0 * step)
            });
            let square = slope.norm_squared();
            if square.is_nan() || square < 1e-16 {
                return None;
            }
            let delta = &slope * ((target - distance) / square);
            let shorter = (0.5 / delta.norm()).min(1.0);
            state = self.model.moved(&state, &(delta * shorter));
        }
        None
    }
}
