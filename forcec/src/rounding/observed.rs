//! Observed rounding errors of a kernel: its statements evaluated in 320 bits.
//!
//! In: an analysis and a state. Out: the error of each returned entry, rounded to a double. It never exceeds
//! the bound of [`crate::rounding::Analysis::entries`]; a test checks that for every kernel of the library.

use crate::kernel::{Kernel, Precision};
use crate::model::outputs::Part;
use crate::rounding::{Analysis, Entry, STATES, relative};
use crate::sample::states::Family;
use crate::verify::big::Big;

impl Analysis<'_> {
    /// The exact entries with the errors of `entries`; `None` if the statements have no exact value here.
    pub fn observed(&self, values: &[f64], entries: &[Entry]) -> Option<Vec<Entry>> {
        let input = |slot| Big::from_f64(self.input(values, slot));
        let exact = self.kernel.evaluate(&input)?;
        let error = |(exact, entry): (&Big, &Entry)| {
            let error = (exact.clone() - Big::from_f64(entry.value)).abs();
            exact.is_finite().then(|| Entry { value: exact.to_f64(), error: error.to_f64() })
        };
        exact.iter().zip(entries).map(error).collect()
    }
}

/// Bounds and observed errors of one output over some states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Comparison {
    /// The output.
    pub part: Part,
    /// The largest ratio of an error bound to the largest entry, over states with a bound.
    pub bound: f64,
    /// The largest ratio of an error to the largest entry, over the same states.
    pub observed: f64,
    /// The largest ratio of an entry's error to its bound.
    pub quotient: f64,
    /// The number of compared states.
    pub states: usize,
    /// The number of states without a bound.
    pub unbounded: usize,
}

/// Compares bounds with errors, for every output, at [`STATES`] states of each family.
pub fn compare(kernel: &Kernel, precision: Precision, families: &[Family]) -> Vec<Comparison> {
    let analysis = Analysis::new(kernel, precision);
    let none =
        |(part, _)| Comparison { part, bound: 0.0, observed: 0.0, quotient: 0.0, states: 0, unbounded: 0 };
    let mut found: Vec<Comparison> = analysis.parts().into_iter().map(none).collect();
    for (family, index) in families.iter().flat_map(|family| (0..STATES).map(move |index| (*family, index))) {
        let Some((values, entries)) = analysis.regular(family, index) else { continue };
        let Some(errors) = analysis.observed(&values, &entries) else { continue };
        let mut start = 0;
        for (comparison, (_, length)) in found.iter_mut().zip(analysis.parts()) {
            comparison.see(&entries[start..start + length], &errors[start..start + length]);
            start += length;
        }
    }
    found
}

impl Comparison {
    /// Adds one state: the entries with their bounds, and the exact entries with the errors.
    fn see(&mut self, entries: &[Entry], errors: &[Entry]) {
        self.states += 1;
        let pairs = entries.iter().zip(errors).filter(|(_, error)| error.error > 0.0);
        self.quotient = pairs.map(|(entry, error)| error.error / entry.error).fold(self.quotient, f64::max);
        let Some(bound) = relative(entries) else {
            self.unbounded += 1;
            return;
        };
        let largest = errors.iter().map(|entry| entry.value.abs()).fold(0.0, f64::max);
        let error = errors.iter().map(|entry| entry.error).fold(0.0, f64::max);
        self.bound = self.bound.max(bound);
        self.observed = self.observed.max(if error == 0.0 { 0.0 } else { error / largest });
    }
}
