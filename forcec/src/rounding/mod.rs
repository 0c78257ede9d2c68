//! Bounds on the rounding error of a kernel's outputs, by running error analysis of its statements.
//!
//! In: a kernel and a precision. Out: for each output a bound on its error relative to its largest entry,
//! over states drawn within the domains of the parameters. The printed statements are evaluated in their
//! order and association, each value with a rigorous error bound (`running.rs`): Wilkinson's running error
//! analysis, Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., §3.3. The analysis uses IEEE
//! operations and functions made of them only, so the bounds are reproducible on every platform.

mod functions;
#[cfg(feature = "verify")]
pub mod observed;
mod running;

use crate::kernel::{Kernel, Precision};
use crate::math::random::Random;
use crate::model::bodies::{Signature, Slot};
use crate::model::outputs::Part;
use crate::sample::inputs::Places;
use crate::sample::states::{Family, draw, seed};
use running::{Double, Running, Signed, Single};
use std::cell::Cell;

/// The number of states behind the bounds in a kernel's head comment.
pub const STATES: usize = 16;
/// Draws per state that must have a force, before a state without force is accepted.
const DRAWS: u64 = 12;

/// The error bound of one output.
#[derive(Clone, PartialEq, Debug)]
pub struct Bound {
    /// The output.
    pub part: Part,
    /// The largest ratio of an entry's error bound to the largest entry, over states with a bound.
    pub relative: f64,
    /// The number of states without a bound: a divisor may be zero, a branch may change, or sums may cancel.
    pub unbounded: usize,
}

/// The error bounds of a kernel's outputs.
#[derive(Clone, PartialEq, Debug)]
pub struct Rounding {
    /// The precision of the kernel's operations.
    pub precision: Precision,
    /// The number of states.
    pub states: usize,
    /// The bounds of outputs that are nonzero at some state.
    pub bounds: Vec<Bound>,
}

/// One entry of an output, as a kernel computes it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Entry {
    /// The returned value.
    pub value: f64,
    /// A bound on the distance to the value of the statements without rounding; infinite if unknown.
    pub error: f64,
}

/// A kernel, prepared for evaluation at states.
pub struct Analysis<'a> {
    kernel: &'a Kernel,
    precision: Precision,
    places: Places,
    /// Whether the last two parameters are the stiffness and damping of a constraint.
    gains: bool,
}

impl<'a> Analysis<'a> {
    /// Prepares a kernel that computes in this precision.
    pub fn new(kernel: &'a Kernel, precision: Precision) -> Analysis<'a> {
        let signature = kernel.given();
        let last: Vec<&str> = signature.parameters.iter().rev().take(2).map(|p| p.name.as_str()).collect();
        Analysis {
            kernel,
            precision,
            places: Places::new(signature),
            gains: last == ["damping", "stiffness"],
        }
    }

    /// A random state of a family, rounded to the kernel's precision.
    pub fn state(&self, family: Family, number: u64) -> Vec<f64> {
        let mut random = Random::new(seed(1, family, number));
        let mut values = draw(&self.places, self.gains, family, number as usize, &mut random).values;
        if self.precision == Precision::F32 {
            values.iter_mut().for_each(|x| *x = f64::from(*x as f32));
        }
        values
    }

    /// The value of an argument's entry at a state.
    pub fn input(&self, values: &[f64], slot: Slot) -> f64 {
        values[self.places.place(slot)]
    }

    /// All entries of all outputs, row by row.
    pub fn entries(&self, values: &[f64]) -> Vec<Entry> {
        // Doubled precision computes the losses of sums and products, which unsigned bounds would ignore.
        match (self.precision, self.kernel.schedule.doubled) {
            (Precision::F64, false) => self.evaluate::<Double>(values),
            (Precision::F32, false) => self.evaluate::<Single>(values),
            (Precision::F64, true) => self.evaluate::<Signed<Double>>(values),
            (Precision::F32, true) => self.evaluate::<Signed<Single>>(values),
        }
    }

    fn evaluate<F: running::Format>(&self, values: &[f64]) -> Vec<Entry> {
        let undecided = Cell::new(false);
        let input = |slot| Running::<F>::input(self.input(values, slot), &undecided);
        let found = self.kernel.evaluate(&input).expect("a schedule writes every entry");
        let error = |x: &Running<F>| if undecided.get() { f64::INFINITY } else { x.error() };
        found.iter().map(|x| Entry { value: x.value(), error: error(x) }).collect()
    }

    /// The outputs with their numbers of entries.
    pub fn parts(&self) -> Vec<(Part, usize)> {
        match &self.kernel.packing {
            Some(packing) => packing.tables.iter().map(|table| (table.part, table.entries.len())).collect(),
            None => {
                let length = |part: &Part| (*part, part.length(self.signature()));
                self.kernel.schedule.parts.iter().map(length).collect()
            }
        }
    }

    fn signature(&self) -> &Signature {
        self.kernel.given()
    }

    /// A regular state and its entries: of a few draws the first with finite entries of which some are
    /// nonzero, else one with finite entries.
    pub fn regular(&self, family: Family, index: usize) -> Option<(Vec<f64>, Vec<Entry>)> {
        let mut passive = None;
        for number in 0..DRAWS {
            let values = self.state(family, index as u64 * DRAWS + number);
            let entries = self.entries(&values);
            if entries.iter().all(|entry| entry.value.is_finite()) {
                if entries.iter().any(|entry| entry.value != 0.0) {
                    return Some((values, entries));
                }
                passive.get_or_insert((values, entries));
            }
        }
        passive
    }
}

/// The bound of each output over evaluated states.
pub fn bounds(analysis: &Analysis, states: &[Vec<Entry>]) -> Vec<Bound> {
    let mut start = 0;
    let mut bounds = Vec::new();
    for (part, length) in analysis.parts() {
        let range = start..start + length;
        start += length;
        let mut bound = Bound { part, relative: 0.0, unbounded: 0 };
        let mut zero = true;
        for entries in states.iter().map(|state| &state[range.clone()]) {
            zero &= entries.iter().all(|entry| entry.value == 0.0 && entry.error == 0.0);
            match relative(entries) {
                Some(error) => bound.relative = bound.relative.max(error),
                None => bound.unbounded += 1,
            }
        }
        bounds.extend((!zero).then_some(bound));
    }
    bounds
}

/// The largest error bound over the least size of the largest entry, rounded up; `None` if that size is zero.
pub fn relative(entries: &[Entry]) -> Option<f64> {
    let error = entries.iter().map(|entry| entry.error).fold(0.0, f64::max);
    let size = entries.iter().map(|entry| entry.value.abs() - entry.error).fold(0.0, f64::max);
    match (error == 0.0, error < size) {
        (true, _) => Some(0.0),
        (_, true) => Some(error / size * (1.0 + 4.0 * f64::EPSILON)),
        _ => None,
    }
}

/// The error bounds of a kernel's outputs at random states.
pub fn rounding(kernel: &Kernel, precision: Precision) -> Rounding {
    let analysis = Analysis::new(kernel, precision);
    let states = (0..STATES).filter_map(|index| analysis.regular(Family::Random, index));
    let states: Vec<Vec<Entry>> = states.map(|(_, entries)| entries).collect();
    Rounding { precision, states: states.len(), bounds: bounds(&analysis, &states) }
}

impl Rounding {
    /// The sentences in the head comment of a kernel; none if no state is regular.
    pub fn lines(&self) -> Vec<String> {
        let bounded = self.bounds.iter().filter(|bound| bound.unbounded < self.states);
        let bounded: Vec<String> = bounded
            .map(|bound| match bound.relative {
                0.0 => format!("{} exact", bound.part),
                relative => format!("{} ≤ {}", bound.part, upward(relative)),
            })
            .collect();
        let mut lines = Vec::new();
        if !bounded.is_empty() {
            let states = self.states;
            let rounded = self.bounds.iter().any(|bound| bound.relative > 0.0);
            let unit = if rounded { " of the largest entry" } else { "" };
            lines.push(format!("Rounding: {}{unit}, at {states} random states.", bounded.join(", ")));
        }
        let open = self.bounds.iter().filter(|bound| bound.unbounded > 0);
        lines.extend(open.map(|bound| {
            format!(
                "At {} of {} random states rounding of {} has no bound.",
                bound.unbounded, self.states, bound.part
            )
        }));
        lines
    }
}

/// A number as decimal text with two digits, rounded up.
pub fn upward(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let text = format!("{x:.1e}");
    let reads = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
    if reads(&text) >= x {
        return text;
    }
    let (digits, exponent) = text.split_once('e').expect("a number with an exponent");
    let tenths = digits.replace('.', "").parse::<u32>().map_or(99, |tenths| tenths) + 1;
    // 10.0e3 is a valid number and prints as 1.0e4.
    format!("{:.1e}", reads(&format!("{tenths}e{exponent}")) / 10.0)
}
