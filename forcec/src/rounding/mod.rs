//! How far rounding may take what a kernel computes: running error analysis of its statements.
//!
//! In: a kernel and a precision. Out: for each of its results a bound on its error relative to its largest entry, over
//! states drawn within the domains of the parameters. The statements that are printed are evaluated, in the order and
//! with the association that they have, each value with a rigorous bound of its error (`running.rs`): Wilkinson's running
//! error analysis, Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., §3.3. Only IEEE operations are used,
//! and functions made of them, so that the bounds are the same on every machine.

mod functions;
#[cfg(feature = "verify")]
pub mod observed;
mod running;

use crate::kernel::{Kernel, Precision};
use crate::model::bodies::{Signature, Slot};
use crate::model::outputs::Part;
use crate::sample::inputs::Places;
use crate::sample::states::{Family, Random, draw, seed};
use running::{Double, Running, Signed, Single};
use std::cell::Cell;

/// States behind what the head of a kernel says.
pub const STATES: usize = 16;
/// Draws for a state with a force before one without will do, and draws for a regular state before the search ends.
const DRAWS: u64 = 12;

/// What rounding may do to one result.
#[derive(Clone, PartialEq, Debug)]
pub struct Bound {
    /// The result.
    pub part: Part,
    /// The largest bound of an entry's error relative to the largest entry, over the states that have one.
    pub relative: f64,
    /// States at which nothing bounds the error by the largest entry: a quotient whose divisor may be zero, a choice that
    /// rounding may turn, or sums that cancel to the last digit.
    pub unbounded: usize,
}

/// What rounding may do to the results of a kernel.
#[derive(Clone, PartialEq, Debug)]
pub struct Rounding {
    /// What the kernel computes in.
    pub precision: Precision,
    /// How many states were drawn.
    pub states: usize,
    /// The results that are not zero at every state.
    pub bounds: Vec<Bound>,
}

/// One entry as a kernel computes it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Entry {
    /// What the kernel returns.
    pub value: f64,
    /// How far that is at most from what its statements give without rounding; infinite where nothing bounds it.
    pub error: f64,
}

/// The statements of a kernel, ready to be evaluated at states.
pub struct Analysis<'a> {
    kernel: &'a Kernel,
    precision: Precision,
    places: Places,
    /// Whether the last two parameters are the stiffness and damping of a constraint.
    gains: bool,
}

impl<'a> Analysis<'a> {
    /// Of this kernel, computing in this precision.
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

    /// A state of a family, in numbers that the kernel can take.
    pub fn state(&self, family: Family, number: u64) -> Vec<f64> {
        let mut random = Random::new(seed(1, family, number));
        let mut values = draw(&self.places, self.gains, family, number as usize, &mut random).values;
        if self.precision == Precision::F32 {
            values.iter_mut().for_each(|x| *x = f64::from(*x as f32));
        }
        values
    }

    /// The entry of an argument among the values of a state.
    pub fn input(&self, values: &[f64], slot: Slot) -> f64 {
        values[self.places.place(slot)]
    }

    /// Every entry of every result, row by row.
    pub fn entries(&self, values: &[f64]) -> Vec<Entry> {
        // Doubled precision computes what sums and products lose: bounds of their size do not see that it does.
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

    /// Each result with its number of entries.
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

    /// The entries at a regular state: the first of a few draws at which all are finite and some not zero, else one at which
    /// all are finite.
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

/// The bound of each result over states that were evaluated.
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

/// The largest bound relative to the least that the largest exact entry can be, rounded up; `None` where that is nothing.
pub fn relative(entries: &[Entry]) -> Option<f64> {
    let error = entries.iter().map(|entry| entry.error).fold(0.0, f64::max);
    let size = entries.iter().map(|entry| entry.value.abs() - entry.error).fold(0.0, f64::max);
    match (error == 0.0, error < size) {
        (true, _) => Some(0.0),
        (_, true) => Some(error / size * (1.0 + 4.0 * f64::EPSILON)),
        _ => None,
    }
}

/// What rounding may do to the results of a kernel, at random states.
pub fn rounding(kernel: &Kernel, precision: Precision) -> Rounding {
    let analysis = Analysis::new(kernel, precision);
    let states = (0..STATES).filter_map(|index| analysis.regular(Family::Random, index));
    let states: Vec<Vec<Entry>> = states.map(|(_, entries)| entries).collect();
    Rounding { precision, states: states.len(), bounds: bounds(&analysis, &states) }
}

impl Rounding {
    /// What the head of a kernel says, in a line or two; nothing of a kernel that has no regular state.
    pub fn lines(&self) -> Vec<String> {
        let told = self.bounds.iter().filter(|bound| bound.unbounded < self.states);
        let told: Vec<String> = told
            .map(|bound| match bound.relative {
                0.0 => format!("{} exact", bound.part),
                relative => format!("{} ≤ {}", bound.part, upward(relative)),
            })
            .collect();
        let mut lines = Vec::new();
        if !told.is_empty() {
            let states = self.states;
            let rounded = self.bounds.iter().any(|bound| bound.relative > 0.0);
            let unit = if rounded { " of the largest entry" } else { "" };
            lines.push(format!("Rounding: {}{unit}, at {states} random states.", told.join(", ")));
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

/// Two digits, not below x.
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
    // 10.0e3 reads as well as 1.0e4.
    format!("{:.1e}", reads(&format!("{tenths}e{exponent}")) / 10.0)
}
