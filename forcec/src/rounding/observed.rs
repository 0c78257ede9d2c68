//! How far a kernel is off where it was evaluated: its statements in 320 bits.
//!
//! In: an analysis and a state. Out: for each entry of its results the error of what the kernel returns, rounded to a
//! double. It is never above the bound of [`crate::rounding::Analysis::entries`], which is tested for every kernel of the library.

use crate::kernel::{Kernel, Precision};
use crate::model::outputs::Part;
use crate::rounding::{Analysis, Entry, STATES, relative};
use crate::sample::states::Family;
use crate::verify::big::Big;

impl Analysis<'_> {
    /// The errors of entries that were computed at this state; `None` where the statements have no value without rounding.
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

/// What was found of one result over some states.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Comparison {
    /// The result.
    pub part: Part,
    /// The largest bound of an error relative to the largest entry, over the states that have one.
    pub bound: f64,
    /// The largest error there, likewise.
    pub observed: f64,
    /// The largest quotient of an entry's error and its bound.
    pub quotient: f64,
    /// States that were compared.
    pub states: usize,
    /// States at which nothing bounds the error by the largest entry.
    pub unbounded: usize,
}

/// Bounds beside errors of every result, over as many states of each of some families as the head of a kernel speaks of.
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
    /// Takes in the entries of one state, what they are off by beside what they were bounded by.
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
