//! Central differences in doubles, with estimates of their own error.
//!
//! In: a kernel's force and its derivatives at a state. Out: for every entry agreement, contradiction, or
//! neither if noise and truncation are too large. Steps decrease from a tenth of the state's length; the
//! noise is the error bound of the force over the step, the truncation error the change when the step is
//! halved. A quotient counts only if no finer step contradicts it and no periodic function passes a large
//! part of its period; so a structure smaller than the step raises no false alarm.

use crate::model::bodies::Role;
use crate::sample::inputs::{Coordinate, Places};
use crate::sample::states::State;
use crate::verify::tape::{Bounded, Run, Tape};

/// The result of comparing an entry with differences.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Answer {
    Agrees,
    /// The difference quotient and its tolerance.
    Contradicts(f64, f64),
    Unresolved,
}

/// A contradiction requires an error of this many times the uncertainty.
const SAFETY: f64 = 10.0;
/// An entry is resolved if the uncertainty is below this fraction of the entry …
const RESOLVED: f64 = 1e-2;
/// … or below this fraction of the largest entry of its array.
const NEGLIGIBLE: f64 = 1e-6;
const STEPS: i32 = 9;
/// The largest change of a phase, in radians, that a step may cause.
const WIDEST_PHASE: f64 = 0.5;

/// One quotient and its noise.
#[derive(Clone, Copy)]
struct Quotient {
    value: f64,
    noise: f64,
}

/// Compares one array, `derivative`, with differences of `force`; returns answers row by row.
pub(crate) fn compare(
    force: &Tape,
    places: &Places,
    state: &State,
    coordinates: &[Coordinate],
    derivative: &[Bounded],
) -> Vec<Answer> {
    let rows = places.pose.len();
    let mut errors = vec![0.0; places.length];
    for coordinate in coordinates.iter().filter(|c| c.role == Role::Orientation) {
        for k in 0..4 {
            let at = coordinate.start + k;
            errors[at] = 2.0 * f64::EPSILON * state.values[at].abs();
        }
    }
    let noise: Vec<f64> = force.bounds(&state.values, &errors).iter().map(|f| f.error).collect();
    let middle = force.values(&state.values);
    let largest = derivative.iter().map(|k| k.value.abs()).fold(0.0, f64::max);
    let mut answers = vec![Answer::Unresolved; derivative.len()];
    for (column, coordinate) in coordinates.iter().enumerate() {
        let moves_pose = matches!(coordinate.role, Role::Position | Role::Orientation);
        let scale = if moves_pose { state.scale } else { 1.0 };
        // Pairs of steps h and h/2, from coarse to fine.
        let mut levels: Vec<Vec<(Quotient, Quotient)>> = Vec::new();
        for level in 1..=STEPS {
            let h = scale * 0.1f64.powi(level);
            let pair = [h, h / 2.0].map(|h| quotients(force, &state.values, coordinate, h, &noise, &middle));
            if let [Some(coarse), Some(fine)] = pair {
                levels.push(coarse.into_iter().zip(fine).collect());
            }
        }
        for row in 0..rows {
            let at = row * coordinates.len() + column;
            let entries: Vec<(Quotient, Quotient)> = levels.iter().map(|level| level[row]).collect();
            answers[at] = answer(&entries, derivative[at], largest);
        }
    }
    answers
}

fn answer(levels: &[(Quotient, Quotient)], kernel: Bounded, largest: f64) -> Answer {
    let uncertainty = |(coarse, fine): &(Quotient, Quotient)| {
        2.0 * (coarse.value - fine.value).abs() + coarse.noise + fine.noise
    };
    let consistent = |index: usize| {
        let (_, fine) = levels[index];
        let own = uncertainty(&levels[index]);
        levels[index + 1..].iter().all(|(c, f)| {
            [c, f].iter().all(|finer| {
                let apart = (finer.value - fine.value).abs();
                apart.is_nan() || apart <= own + 2.0 * finer.noise
            })
        })
    };
    let best = (0..levels.len())
        .filter(|index| uncertainty(&levels[*index]).is_finite() && consistent(*index))
        .min_by(|a, b| uncertainty(&levels[*a]).total_cmp(&uncertainty(&levels[*b])));
    let Some(best) = best else { return Answer::Unresolved };
    let value = levels[best].1.value;
    let tolerance = uncertainty(&levels[best]) + kernel.error;
    let error = (value - kernel.value).abs();
    if tolerance.is_finite() && (error.is_nan() || error > SAFETY * tolerance) {
        return Answer::Contradicts(value, SAFETY * tolerance);
    }
    let size = value.abs().max(kernel.value.abs());
    if tolerance <= RESOLVED * size || tolerance <= NEGLIGIBLE * largest || value == kernel.value {
        Answer::Agrees
    } else {
        Answer::Unresolved
    }
}

/// (F(x + h) − F(x − h))/2h; `None` across a branch, or if a sine, cosine or tangent passes a large part of
/// its period: quotients over whole periods can agree with each other although they are wrong.
fn quotients(
    force: &Tape,
    inputs: &[f64],
    coordinate: &Coordinate,
    h: f64,
    noise: &[f64],
    middle: &Run,
) -> Option<Vec<Quotient>> {
    let (mut above, mut below) = (inputs.to_vec(), inputs.to_vec());
    let width = moved(&mut above, coordinate, h) - moved(&mut below, coordinate, -h);
    let (above, below) = (force.values(&above), force.values(&below));
    let same = |end: &Run| {
        let mut phases = end.phases.iter().zip(&middle.phases);
        end.choices == middle.choices && phases.all(|(x, y)| (x - y).abs() <= WIDEST_PHASE || x == y)
    };
    if !same(&above) || !same(&below) || width <= 0.0 {
        return None;
    }
    let quotient = |((high, low), noise): ((f64, f64), &f64)| Quotient {
        value: (high - low) / width,
        // The bound at the center; a step may double it, or raise it from zero.
        noise: 4.0 * (noise + f64::EPSILON * (high.abs() + low.abs())) / width,
    };
    Some(above.outputs.into_iter().zip(below.outputs).zip(noise).map(quotient).collect())
}

/// Moves along a coordinate; returns the length of the step after rounding.
fn moved(inputs: &mut [f64], coordinate: &Coordinate, h: f64) -> f64 {
    let field = &mut inputs[coordinate.start..];
    if coordinate.role != Role::Orientation {
        let before = field[coordinate.axis];
        field[coordinate.axis] = before + h;
        return field[coordinate.axis] - before;
    }
    let (sine, cosine) = (h / 2.0).sin_cos();
    let [x, y, z, w] = [field[0], field[1], field[2], field[3]];
    let turn = match coordinate.axis {
        0 => [w, -z, y, -x],
        1 => [z, w, -x, -y],
        _ => [-y, x, w, -z],
    };
    for (stored, (q, t)) in field.iter_mut().zip([x, y, z, w].into_iter().zip(turn)) {
        *stored = q * cosine + t * sine;
    }
    h
}
