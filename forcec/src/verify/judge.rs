//! Compares the errors of a printed kernel with those of its source, evaluated as written.
//!
//! In: a printed kernel in one precision, and states with exact outputs. Out: the kernel's errors compared
//! with those of the source at the same inputs in the same precision ([`crate::verify::written`]). The rule
//! applies to every block of an output, the rows of one body by the columns of one body: the largest error of
//! the kernel exceeds [`FACTOR`] times the largest error of the source by at most [`UNITS`] units in the last
//! place of the output's largest entry; a block that is finite in the source is finite in the kernel. The
//! source's rounding errors can cancel at a single state. If the rule seems broken, the source's error is the
//! largest at that state and a few neighbours, or infinite.

use crate::math::number::Precision;
use crate::math::random::Random;
use crate::model::bodies::Slot;
use crate::model::outputs::{Array, Axis, Output, Part, spans};
use crate::sample::inputs::Places;
use crate::sample::states::{Family, State};
use crate::scalar::Id;
use crate::verify::big::Big;
use crate::verify::dual::Scalar;
use crate::verify::report::{TextComparison, TextEntry};
use crate::verify::written::{Written, is_second};
use crate::verify::{Subject, quaternions};
use std::ops::Range;

/// The factor on the error of the source.
pub(crate) const FACTOR: f64 = 4.0;
/// The additional tolerance, in units in the last place of the largest entry of an output.
const UNITS: f64 = 8.0;

/// The number of neighbouring states evaluated if a single state breaks the rule.
const NEIGHBOURS: usize = 8;

/// After this many failing blocks, further failures are not examined at neighbouring states.
const ENOUGH: usize = 24;

/// Evaluates a kernel, given the value of each argument.
pub type Evaluate<'a> = dyn Fn(&dyn Fn(Slot) -> f64) -> Option<Vec<f64>> + 'a;

/// A printed kernel in one precision.
pub struct Printed<'a> {
    /// The precision.
    pub precision: Precision,
    /// Computes the outputs, every array row by row, in the order of the program, as doubles that the
    /// precision can represent. `None` if an entry is never written.
    pub evaluate: &'a Evaluate<'a>,
}

/// The exact outputs at a state.
pub(super) struct Known {
    /// Every known output row by row, in the order of the program.
    pub(super) results: Vec<Option<Vec<Big>>>,
    /// A bound on their error.
    pub(super) noise: f64,
    /// Whether some derivative exists only while arguments are constant; kernels need not be finite then.
    pub(super) edges: bool,
}

impl Known {
    fn has_second(&self, arrays: &[Array<Id>]) -> bool {
        let mut results = arrays.iter().zip(&self.results);
        results.any(|(array, known)| is_second(array.part) && known.is_some())
    }
}

/// Every output row by row, in the order of the program; `None` for outputs left out.
type Entries = Vec<Option<Vec<f64>>>;

/// Evaluates the outputs of the source at a state.
type Results<'a> = Box<dyn Fn(&[f64], bool) -> Entries + 'a>;

/// The comparison of one kernel in one precision so far.
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

    /// The state rounded to this precision; `None` if it overflows.
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

    /// Compares at a state of this precision; `exact_at` computes the exact outputs at another state.
    pub(super) fn see(
        &mut self,
        family: Family,
        state: &State,
        truth: &Known,
        exact_at: &dyn Fn(&State) -> Option<Known>,
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
                // Entries that overflow the format need not be finite.
                let holds = |k: usize| exact[k].to_f64().abs() <= self.largest_number();
                let is_lost = |k: &usize| !truth.edges && holds(*k) && !kernel[*k].is_finite();
                let lost = places.iter().copied().find(is_lost);
                let Some((place, error)) = furthest(&places, kernel, exact) else { continue };
                let by_text =
                    |written: &[f64], exact: &[Big]| furthest(&places, written, exact).map_or(0.0, |x| x.1);
                let mut text_error = by_text(written, exact);
                let ratio = |text_error: f64| match lost {
                    // The source's value is not finite, so no comparison is possible.
                    _ if !text_error.is_finite() => 0.0,
                    Some(_) => f64::INFINITY,
                    None if !error.is_finite() || error <= allowed => 0.0,
                    None => (error - allowed) / text_error,
                };
                let enough = self.found.failures() >= ENOUGH;
                let broken = ratio(text_error) > FACTOR;
                if broken && enough && lost.is_none() {
                    continue;
                }
                if broken && !enough {
                    let neighbours = neighbours.get_or_insert_with(|| self.neighbours(state, exact_at));
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

    /// Neighbouring states with their exact outputs and those of the source. Every number moves by a few
    /// units in the last place, except zeros, quaternions and compile-time constants.
    fn neighbours(
        &self,
        state: &State,
        exact_at: &dyn Fn(&State) -> Option<Known>,
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
            if let Some(known) = exact_at(&state) {
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

    /// The unit in the last place at a size, plus a margin for underflow.
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

/// The entry with the largest error, and the error; NaN counts as infinite.
fn furthest(places: &[usize], computed: &[f64], exact: &[Big]) -> Option<(usize, f64)> {
    let error = |place: usize| match (exact[place].clone() - Big::from_f64(computed[place])).to_f64().abs() {
        error if error.is_nan() => f64::INFINITY,
        error => error,
    };
    let errors = places.iter().map(|place| (*place, error(*place)));
    errors.max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The quaternion of floats near q whose length is nearest to one.
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
