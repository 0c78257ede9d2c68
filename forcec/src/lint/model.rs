//! Evaluates a force function at random and modified states.
//!
//! In: a definition. Out: its value, force and derivatives in doubles at any state; states drawn from the
//! domains, moved along tangent coordinates, or projected onto a constraint. A fixed seed makes results
//! reproducible on the same platform.

use crate::derive::derive;
use crate::lower::lower;
use crate::math::random::Random;
use crate::model::bodies::Role;
use crate::model::outputs::Part;
use crate::sample::inputs::Places;
use crate::sample::states::draw;
use crate::scalar::Id;
use crate::vector::FORMULATIONS;
use crate::vector::definition::{Definition, Law};
use crate::verify::Family;
use crate::verify::tape::Tape;
use nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3};
use std::ops::Range;

/// A definition, prepared for evaluation.
pub(super) struct Model<'a> {
    pub(super) definition: &'a Definition,
    pub(super) layout: Places,
    tape: Tape,
    parts: Vec<(Part, Range<usize>)>,
}

/// The outputs at a state; `value` and `jacobian` are empty for a force.
pub(super) struct Response {
    pub(super) value: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    pub(super) force: DVector<f64>,
    pub(super) dfdx: DMatrix<f64>,
    pub(super) dfdv: DMatrix<f64>,
}

impl Response {
    pub(super) fn is_finite(&self) -> bool {
        let all = [self.value.as_slice(), self.jacobian.as_slice(), self.force.as_slice()];
        let all = all.into_iter().chain([self.dfdx.as_slice(), self.dfdv.as_slice()]);
        all.flatten().all(|x| x.is_finite())
    }
}

/// The longest step of Newton's method.
const LONGEST: f64 = 0.5;
const ITERATIONS: usize = 60;
/// A constraint is satisfied if its rows are at most this large.
const SATISFIED: f64 = 1e-6;

impl<'a> Model<'a> {
    pub(super) fn new(definition: &'a Definition) -> Model<'a> {
        let mut wanted = Part::DEFAULT.to_vec();
        if definition.law.rows() > 0 {
            wanted.extend([Part::Value, Part::Jacobian]);
        }
        let wanted = Part::in_order(wanted);
        // Lowers without optimisation, because only values matter here.
        let derived = derive(definition, &wanted, FORMULATIONS[0]);
        let program = lower(derived, false, usize::MAX, None).expect("nothing bounds it");
        let layout = Places::new(&program.signature);
        let outputs: Vec<Id> = program.outputs().collect();
        let tape = Tape::new(&program, &layout, &outputs);
        let mut end = 0;
        let mut range = |length: usize| {
            end += length;
            end - length..end
        };
        let parts = program.arrays.iter().map(|array| (array.part, range(array.entries.len()))).collect();
        Model { definition, layout, tape, parts }
    }

    pub(super) fn is_constraint(&self) -> bool {
        matches!(self.definition.law, Law::Constraint { .. })
    }

    pub(super) fn is_unilateral(&self) -> bool {
        matches!(self.definition.law, Law::Constraint { unilateral: true, .. })
    }

    /// The number of degrees of freedom.
    pub(super) fn dofs(&self) -> usize {
        self.layout.pose.len()
    }

    pub(super) fn at(&self, state: &[f64]) -> Response {
        let all = self.tape.values(state).outputs;
        let n = self.dofs();
        let part = |wanted: Part| {
            let found = self.parts.iter().find(|(part, _)| *part == wanted);
            found.map_or(&[][..], |(_, range)| &all[range.clone()])
        };
        let jacobian = part(Part::Jacobian);
        Response {
            value: DVector::from_row_slice(part(Part::Value)),
            jacobian: DMatrix::from_row_slice(jacobian.len() / n.max(1), n, jacobian),
            force: DVector::from_row_slice(part(Part::Force)),
            dfdx: DMatrix::from_row_slice(n, n, part(Part::Dfdx)),
            dfdv: DMatrix::from_row_slice(n, n, part(Part::Dfdv)),
        }
    }

    /// States of order one with finite outputs; parameters are drawn from their domains.
    pub(super) fn draw(&self, count: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = Random::new(seed);
        let drawn = (0..4 * count).map(|index| {
            let mut state =
                draw(&self.layout, self.is_constraint(), Family::Random, index, &mut random).values;
            self.set_gains(&mut state, 1.0, 0.0);
            state
        });
        drawn.filter(|state| self.at(state).is_finite()).take(count).collect()
    }

    /// Sets the stiffness and damping of all rows of a constraint.
    pub(super) fn set_gains(&self, state: &mut [f64], stiffness: f64, damping: f64) {
        if !self.is_constraint() {
            return;
        }
        let parameters = &self.layout.signature.parameters;
        for (back, gain) in [(2, stiffness), (1, damping)] {
            let place = parameters.len() - back;
            if parameters[place].value.is_none() {
                let at = self.layout.parameter(place);
                state[at..at + parameters[place].ty.length() as usize].fill(gain);
            }
        }
    }

    pub(super) fn velocity(&self, state: &[f64]) -> DVector<f64> {
        let all = self.layout.velocity.iter().map(|c| state[c.start + c.axis]);
        DVector::from_iterator(self.dofs(), all)
    }

    pub(super) fn set_velocity(&self, state: &mut [f64], velocity: &DVector<f64>) {
        for (c, v) in self.layout.velocity.iter().zip(velocity.iter()) {
            state[c.start + c.axis] = *v;
        }
    }

    /// The state with zero velocities.
    pub(super) fn rest(&self, state: &[f64]) -> Vec<f64> {
        let mut state = state.to_vec();
        self.set_velocity(&mut state, &DVector::zeros(self.dofs()));
        state
    }

    /// x ← x + δx, q ← exp(δθ/2) q
    pub(super) fn moved(&self, state: &[f64], delta: &DVector<f64>) -> Vec<f64> {
        let mut state = state.to_vec();
        for (k, block) in self.layout.pose.chunks(3).enumerate() {
            let delta = Vector3::new(delta[3 * k], delta[3 * k + 1], delta[3 * k + 2]);
            let field = &mut state[block[0].start..];
            if block[0].role == Role::Orientation {
                let q = Quaternion::new(field[3], field[0], field[1], field[2]);
                let q = (UnitQuaternion::from_scaled_axis(delta).into_inner() * q).normalize();
                field[..4].copy_from_slice(q.coords.as_slice());
            } else {
                field.iter_mut().zip(delta.iter()).for_each(|(x, d)| *x += d);
            }
        }
        state
    }

    /// A state that satisfies the constraint, or the row nearest to zero of a unilateral constraint: Newton's
    /// method with minimal steps along the coordinates `free`; `None` without convergence.
    pub(super) fn satisfied(&self, state: &[f64], free: &Range<usize>) -> Option<Vec<f64>> {
        let mut state = state.to_vec();
        for _ in 0..ITERATIONS {
            let Response { mut value, mut jacobian, .. } = self.at(&state);
            if self.is_unilateral() {
                let nearest = value.map(f64::abs).imin();
                (value, jacobian) =
                    (value.rows(nearest, 1).into_owned(), jacobian.rows(nearest, 1).into_owned());
            }
            if value.amax() <= SATISFIED {
                return Some(state);
            }
            let jacobian = jacobian.columns(free.start, free.len()).into_owned();
            let step = jacobian.svd(true, true).solve(&value, 1e-9).ok()?;
            let shorter = (LONGEST / step.norm()).min(1.0);
            let mut delta = DVector::zeros(self.dofs());
            delta.rows_mut(free.start, free.len()).copy_from(&(step * -shorter));
            let next = self.moved(&state, &delta);
            // If the constraint is singular where it is satisfied, a state close to that suffices.
            if !self.at(&next).is_finite() {
                return (value.amax() < 0.1).then_some(state);
            }
            state = next;
        }
        None
    }

    /// A unit vector in the tangent space.
    pub(super) fn direction(&self, random: &mut Random, free: &Range<usize>) -> DVector<f64> {
        let mut direction = DVector::zeros(self.dofs());
        direction.rows_mut(free.start, free.len()).iter_mut().for_each(|x| *x = random.uniform(-1.0, 1.0));
        let norm = direction.norm();
        if norm > 0.0 { direction / norm } else { direction }
    }
}

/// Of the symmetric part, the smallest eigenvalue and the largest absolute eigenvalue.
pub(super) fn extremes(matrix: &DMatrix<f64>) -> (f64, f64) {
    let symmetric = (matrix + matrix.transpose()) * 0.5;
    let values = symmetric.symmetric_eigenvalues();
    (values.min(), values.amax())
}

/// The median; `None` of an empty list.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
