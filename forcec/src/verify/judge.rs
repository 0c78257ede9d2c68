//! A kernel is never worse than its author's text.
//!
//! In: a kernel as it is printed in one precision, and states with what the mathematics gives there. Out: how its errors compare
//! with those of the source evaluated as written, in the same precision, at the same inputs ([`crate::verify::written`]). The rule,
//! for every block of a result, the rows of one body by the columns of one body: the largest error of the kernel is at most
//! [`FACTOR`] times the largest error of the text, and [`UNITS`] units in the last place of the largest entry of the result; a block
//! that is finite in the text is finite in the kernel. At a single state the roundings of the text may cancel by luck: where
//! the rule seems broken, the error of the text is the largest at the state and at a few states beside it, infinite where
//! the text is.

use crate::math::number::Precision;
use crate::model::bodies::Slot;
use crate::model::outputs::{Array, Axis, Output, Part, spans};
use crate::sample::inputs::Places;
use crate::sample::states::{Family, Random, State};
use crate::scalar::Id;
use crate::verify::big::Big;
use crate::verify::dual::Scalar;
use crate::verify::report::{TextComparison, TextEntry};
use crate::verify::written::{Written, is_second};
use crate::verify::{Subject, quaternions};
use std::ops::Range;

/// What the error of the text is multiplied by.
pub(crate) const FACTOR: f64 = 4.0;
/// Units in the last place of the largest entry of a result that are allowed besides.
const UNITS: f64 = 8.0;

/// States beside one at which the text is evaluated too, where the state alone says that the kernel is worse.
const NEIGHBOURS: usize = 8;

/// Blocks that break the rule before others are no longer looked at closely: the verdict is known.
const ENOUGH: usize = 24;

/// What a kernel gives for the value of each argument.
pub type Evaluate<'a> = dyn Fn(&dyn Fn(Slot) -> f64) -> Option<Vec<f64>> + 'a;

/// A kernel as it is printed, in one precision.
pub struct Printed<'a> {
    /// The precision.
    pub precision: Precision,
    /// Its outputs, every array row by row, in the order of the program, given the value of each argument. Numbers of the
    /// precision, as doubles. `None` if an entry is never written.
    pub evaluate: &'a Evaluate<'a>,
}

/// What the mathematics gives at a state.
pub(super) struct Known {
    /// Every result row by row, in the order of the program, where it is known.
    pub(super) results: Vec<Option<Vec<Big>>>,
    /// What it may be off by.
    pub(super) noise: f64,
    /// Whether some formula has no derivative but for its arguments staying what they are: no kernel has to be finite there.
    pub(super) edges: bool,
}

impl Known {
    fn has_second(&self, arrays: &[Array<Id>]) -> bool {
        let mut results = arrays.iter().zip(&self.results);
        results.any(|(array, known)| is_second(array.part) && known.is_some())
    }
}

/// Every result row by row, in the order of the program; `None` for those left out.
type Entries = Vec<Option<Vec<f64>>>;

/// The results of a text at a state.
type Results<'a> = Box<dyn Fn(&[f64], bool) -> Entries + 'a>;

/// One kernel in one precision, and what was found so far.
pub(super) struct Judge<'a> {
    places: &'a Places,
    arrays: &'a [Array<Id>],
    printed: &'a Printed<'a>,
    text: Results<'a>,
    found: TextComparison,
}

fn text<'a, F: Scalar + 'a>(subject: &Subject<'a>, places: &'a Places) -> Results<'a> {
    let written: Written<F> = Written::new(subject.source, places);
    let parts: Vec<Part> = subject.program.arrays.iter().map(|array| array.part).collect();
    Box::new(move |inputs, second| {
        let second = second && parts.iter().any(|part| is_second(*part));
        let text = written.at(inputs.iter().map(|x| F::of(*x)).collect(), second);
        let wide = |part: &Part| text.part(*part).iter().map(F::wide).collect();
        parts.iter().map(|part| (second || !is_second(*part)).then(|| wide(part))).collect()
    })
}

impl<'a> Judge<'a> {
    pub(super) fn new(subject: &Subject<'a>, places: &'a Places, printed: &'a Printed<'a>) -> Judge<'a> {
        let text = match printed.precision {
            Precision::F64 => text::<f64>(subject, places),
            Precision::F32 => text::<f32>(subject, places),
        };
        let found = TextComparison::new(printed.precision);
        Judge { places, arrays: &subject.program.arrays, printed, text, found }
    }

    /// The state as this precision holds it; `None` if it does not.
    pub(super) fn state(&self, state: &State) -> Option<State> {
        if self.printed.precision == Precision::F64 {
            return Some(state.clone());
        }
        let mut values: Vec<f64> = state.values.iter().map(|x| f64::from(*x as f32)).collect();
        for at in quaternions(self.places) {
            let unit = unit_quaternion([0, 1, 2, 3].map(|k| state.values[at + k]));
            values[at..at + 4].copy_from_slice(&unit.map(f64::from));
        }
        values.iter().all(|x| x.is_finite()).then_some(State { values, ..*state })
    }

    /// Compares at a state of this precision, where the truth is known, and is found at states beside it.
    pub(super) fn see(
        &mut self,
        family: Family,
        state: &State,
        truth: &Known,
        beside: &dyn Fn(&State) -> Option<Known>,
    ) {
        self.found.states += 1;
        let Some(kernel) = (self.printed.evaluate)(&|slot| state.values[self.places.place(slot)]) else {
            return;
        };
        let text = (self.text)(&state.values, truth.has_second(self.arrays));
        let mut neighbours: Option<Vec<(Known, Entries)>> = None;
        let mut start = 0;
        for (index, array) in self.arrays.iter().enumerate() {
            let kernel = &kernel[start..start + array.entries.len()];
            start += array.entries.len();
            let (Some(exact), Some(written)) = (&truth.results[index], &text[index]) else { continue };
            let sizes = exact.iter().map(|x| x.to_f64().abs()).filter(|x| *x > truth.noise);
            let whole = self.unit(sizes.fold(0.0, f64::max));
            let allowed = UNITS * whole + truth.noise;
            let (rows, columns) = self.blocks(array);
            for (rows, columns) in rows.iter().flat_map(|rows| columns.iter().map(move |c| (rows, c))) {
                let places = rows.clone().flat_map(|r| columns.clone().map(move |c| r * array.columns + c));
                let places: Vec<usize> = places.collect();
                // Of what is beyond the format nothing finite is asked.
                let holds = |k: usize| exact[k].to_f64().abs() <= self.largest_number();
                let is_lost = |k: &usize| !truth.edges && holds(*k) && !kernel[*k].is_finite();
                let lost = places.iter().copied().find(is_lost);
                let Some((place, error)) = furthest(&places, kernel, exact) else { continue };
                let by_text =
                    |written: &[f64], exact: &[Big]| furthest(&places, written, exact).map_or(0.0, |x| x.1);
                let mut text_error = by_text(written, exact);
                let ratio = |text_error: f64| match lost {
                    // Where the text is not finite there is nothing to compare with.
                    _ if !text_error.is_finite() => 0.0,
                    Some(_) => f64::INFINITY,
                    None if !error.is_finite() || error <= allowed => 0.0,
                    None => (error - allowed) / text_error,
                };
                if ratio(text_error) > FACTOR {
                    if self.found.failures() >= ENOUGH {
                        continue;
                    }
                    let neighbours = neighbours.get_or_insert_with(|| self.neighbours(state, beside));
                    let errors = neighbours.iter().filter_map(|(known, written)| {
                        Some(by_text(written[index].as_ref()?, known.results[index].as_ref()?))
                    });
                    text_error = errors.fold(text_error, f64::max);
                }
                let (part, place, ratio) = (array.part, lost.unwrap_or(place), ratio(text_error));
                let entry = || TextEntry {
                    name: Output::new(part, place / array.columns, place % array.columns)
                        .named(&self.places.signature),
                    block: spans(part, rows, std::slice::from_ref(columns), &self.places.signature),
                    kernel: kernel[place],
                    text: written[place],
                    exact: exact[place].to_f64(),
                    error,
                    text_error,
                    allowed,
                    units: error / whole,
                    ratio,
                    family,
                    inputs: self.places.inputs(&state.values),
                };
                self.found.note(part, lost.is_some(), ratio, FACTOR, entry);
            }
        }
    }

    /// States beside one, with the truth and the text there: every number a few units in its last place away, but for zeros,
    /// quaternions, and what is known while compiling.
    fn neighbours(
        &self,
        state: &State,
        beside: &dyn Fn(&State) -> Option<Known>,
    ) -> Vec<(Known, Vec<Option<Vec<f64>>>)> {
        let mut stays: Vec<bool> = state.values.iter().map(|x| *x == 0.0).collect();
        for at in quaternions(self.places) {
            stays[at..at + 4].fill(true);
        }
        let signature = &self.places.signature;
        for (p, parameter) in signature.parameters.iter().chain(&signature.extras).enumerate() {
            if parameter.value.is_some() {
                stays[self.places.parameter(p)..][..parameter.ty.length() as usize].fill(true);
            }
        }
        let bits = state.values.iter().fold(0u64, |bits, x| bits.rotate_left(7) ^ x.to_bits());
        let mut random = Random::new(bits);
        let mut found = Vec::new();
        for _ in 0..NEIGHBOURS {
            let mut values = state.values.clone();
            for (x, _) in values.iter_mut().zip(&stays).filter(|(_, stays)| !**stays) {
                for _ in 0..random.next() % 3 {
                    *x = self.next(*x);
                }
                *x = if random.chance(2) { -self.next(-*x) } else { *x };
            }
            let state = State { values, ..*state };
            if let Some(known) = beside(&state) {
                let text = (self.text)(&state.values, known.has_second(self.arrays));
                found.push((known, text));
            }
        }
        found
    }

    fn largest_number(&self) -> f64 {
        match self.printed.precision {
            Precision::F64 => f64::MAX,
            Precision::F32 => f64::from(f32::MAX),
        }
    }

    /// The next larger number of the precision.
    fn next(&self, x: f64) -> f64 {
        match self.printed.precision {
            Precision::F64 => x.next_up(),
            Precision::F32 => f64::from((x as f32).next_up()),
        }
    }

    /// The unit in the last place of a size, and room for what underflows.
    fn unit(&self, size: f64) -> f64 {
        match self.printed.precision {
            Precision::F64 => size.next_up() - size + f64::MIN_POSITIVE,
            Precision::F32 => {
                let below = f64::from(size as f32);
                self.next(below) - below + f64::from(f32::MIN_POSITIVE)
            }
        }
    }

    /// The rows and the columns of each block.
    fn blocks(&self, array: &Array<Id>) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
        let pose = &self.places.pose;
        let mut bodies: Vec<Range<usize>> = Vec::new();
        for (k, coordinate) in pose.iter().enumerate() {
            match bodies.last_mut() {
                Some(body) if pose[body.start].body == coordinate.body => body.end = k + 1,
                _ => bodies.push(k..k + 1),
            }
        }
        let row = array.part.row();
        let rows = if row.rows == Axis::Coordinate {
            bodies.clone()
        } else {
            std::iter::once(0..array.entries.len() / array.columns.max(1)).collect()
        };
        (rows, if row.columns.is_none() { std::iter::once(0..1).collect() } else { bodies })
    }

    pub(super) fn finish(self) -> TextComparison {
        self.found
    }
}

/// The entry among some that is furthest from the truth, and how far; one that is not a number is furthest.
fn furthest(places: &[usize], computed: &[f64], exact: &[Big]) -> Option<(usize, f64)> {
    let error = |place: usize| match (exact[place].clone() - Big::from_f64(computed[place])).to_f64().abs() {
        error if error.is_nan() => f64::INFINITY,
        error => error,
    };
    let errors = places.iter().map(|place| (*place, error(*place)));
    errors.max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The quaternion near q whose stored floats come nearest to length one.
fn unit_quaternion(q: [f64; 4]) -> [f32; 4] {
    let excess = |q: &[f32; 4]| q.iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>() - 1.0;
    let near = q.map(|x| x as f32);
    let mut best = near;
    for choice in 0..625u32 {
        let mut candidate = near;
        for (k, x) in candidate.iter_mut().enumerate() {
            *x = match choice / 5u32.pow(k as u32) % 5 {
                0 => *x,
                1 => x.next_up(),
                2 => x.next_down(),
                3 => x.next_up().next_up(),
                _ => x.next_down().next_down(),
            };
        }
        if excess(&candidate).abs() < excess(&best).abs() {
            best = candidate;
        }
    }
    best
}
