//! Measurements at single states: nonlinearity, stiffness and damping.
//!
//! In: a model and states. Out: dimensionless numbers, medians over the states.

use crate::lint::model::{Model, Response, extremes, median};
use nalgebra::{DMatrix, DVector};

/// The step of the first-order expansion, s.
pub const STEP: f64 = 1.0 / 60.0;
/// Eigenvalues below this fraction of the largest count as rounding errors.
const NEGATIVE: f64 = 1e-9;

/// The relative error of the first-order expansion over a step: |C(x ⊕ hV) − C − hJV| / |hJV|; for an energy
/// or a force with F and ∂F/∂X instead of C and J.
pub(super) fn nonlinearity(model: &Model, states: &[Vec<f64>]) -> Option<f64> {
    let quotient = |state: &Vec<f64>| {
        let velocity = model.velocity(state);
        // Velocities are constant here, also for a force that reads them.
        let pick =
            |at: Response| if model.is_constraint() { (at.value, at.jacobian) } else { (at.force, at.dfdx) };
        let delta = velocity * STEP;
        let (before, slope) = pick(model.at(state));
        let (after, _) = pick(model.at(&model.moved(state, &delta)));
        let linear = slope * delta;
        let quotient = (after - before - &linear).norm() / linear.norm();
        quotient.is_finite().then_some(quotient)
    };
    median(states.iter().filter_map(quotient).collect())
}

/// The stiffness −∂F/∂X at rest.
#[derive(Clone, Copy, Debug)]
pub struct Stiffness {
    /// The number of states at which the symmetric part has a negative eigenvalue, and the number of states.
    pub indefinite: (usize, usize),
    /// The smallest eigenvalue, relative to the largest absolute value.
    pub smallest: f64,
    /// For a constraint, the median of |∂F/∂X + ks JᵀJ| / |∂F/∂X|.
    pub beyond: Option<f64>,
}

pub(super) fn stiffness(model: &Model, states: &[Vec<f64>]) -> Option<Stiffness> {
    let (mut indefinite, mut smallest, mut count) = (0, f64::INFINITY, 0);
    let mut beyond = Vec::new();
    for state in states {
        let at = model.at(&model.rest(state));
        let size = at.dfdx.norm();
        if size == 0.0 || !at.is_finite() {
            continue;
        }
        count += 1;
        let (least, most) = extremes(&-&at.dfdx);
        indefinite += usize::from(least < -NEGATIVE * most);
        smallest = smallest.min(least / most);
        if model.is_constraint() {
            beyond.push((&at.dfdx - gauss_newton(model, &at, 1.0)).norm() / size);
        }
    }
    (count > 0).then(|| Stiffness { indefinite: (indefinite, count), smallest, beyond: median(beyond) })
}

/// −gain JᵀJ over the rows that push.
pub(super) fn gauss_newton(model: &Model, at: &Response, gain: f64) -> DMatrix<f64> {
    let mut jacobian = at.jacobian.clone();
    if model.is_unilateral() {
        for (mut row, _) in jacobian.row_iter_mut().zip(at.value.iter()).filter(|(_, gap)| **gap >= 0.0) {
            row.fill(0.0);
        }
    }
    jacobian.transpose() * jacobian * -gain
}

/// The damping force, the part of the force due to velocities.
#[derive(Clone, Copy, Debug)]
pub struct Damping {
    /// The number of states with damping.
    pub states: usize,
    /// The number of states at which damping adds energy.
    pub active: usize,
    /// The number of states at which damping has no power.
    pub idle: usize,
    /// The number of states at which the symmetric part of ∂F/∂V has a positive eigenvalue.
    pub indefinite: usize,
    /// The relative asymmetry of ∂F/∂V.
    pub asymmetry: f64,
    /// The largest rank of ∂F/∂V, and the degrees of freedom.
    pub rank: (usize, usize),
}

pub(super) fn damping(model: &Model, states: &[Vec<f64>]) -> Option<Damping> {
    let n = model.dofs();
    let mut all = Damping { states: 0, active: 0, idle: 0, indefinite: 0, asymmetry: 0.0, rank: (0, n) };
    for state in states {
        let mut state = state.clone();
        model.set_gains(&mut state, 1.0, 1.0);
        let (moving, still) = (model.at(&state), model.at(&model.rest(&state)));
        let velocity = model.velocity(&state);
        let force: DVector<f64> = moving.force - still.force;
        let size = moving.dfdv.norm();
        if size == 0.0 || !size.is_finite() || !force.norm().is_finite() {
            continue;
        }
        let power = force.dot(&velocity) / (force.norm() * velocity.norm()).max(f64::MIN_POSITIVE);
        let (least, most) = extremes(&-&moving.dfdv);
        all.states += 1;
        all.active += usize::from(power > NEGATIVE);
        all.idle += usize::from(power.abs() <= NEGATIVE);
        all.indefinite += usize::from(least < -NEGATIVE * most);
        all.asymmetry = all.asymmetry.max((&moving.dfdv - moving.dfdv.transpose()).norm() / size);
        all.rank.0 = all.rank.0.max(moving.dfdv.rank(NEGATIVE * size));
    }
    (all.states > 0).then_some(all)
}
