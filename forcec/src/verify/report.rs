//! What a check found, as a value.

use crate::math::number::Precision;
use crate::model::outputs::Part;
use crate::sample::inputs::Inputs;
use crate::sample::states::Family;
use crate::source::span::Span;
use std::collections::BTreeMap;

/// One number that was compared, and the state that shows it.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Which: `dfdx[a.ry][b.x]`.
    pub name: String,
    /// What the mathematics gives.
    pub expected: f64,
    /// What the kernel gives.
    pub computed: f64,
    /// The size of the difference, taken before either was rounded.
    pub error: f64,
    /// The largest error that rounding accounts for.
    pub tolerance: f64,
    /// The kind of state.
    pub family: Family,
    /// The state.
    pub inputs: Inputs,
}

impl Entry {
    /// error/tolerance, a failure above 1; infinite where the kernel gives no finite number.
    pub fn ratio(&self) -> f64 {
        ratio(self.error, self.tolerance)
    }
}

pub(crate) fn ratio(error: f64, tolerance: f64) -> f64 {
    if error == 0.0 {
        0.0
    } else if error.is_finite() {
        error / tolerance
    } else {
        f64::INFINITY
    }
}

/// A kernel's array against the exact oracle.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The array.
    pub array: Part,
    /// How many entries were compared, over all states.
    pub entries: usize,
    /// How many of them were off by more than rounding accounts for.
    pub failures: usize,
    /// Per family the largest error relative to the largest entry of its array, over the states that are resolved;
    /// `None` where none is.
    pub relative: Vec<(Family, Option<f64>)>,
    /// The entry with the largest ratio of error to tolerance.
    pub worst: Option<Entry>,
    /// States of order one at which rounding leaves at least six digits of the array.
    pub sharp: usize,
}

impl Comparison {
    /// Nothing compared yet.
    pub(crate) fn new(array: Part) -> Comparison {
        let relative = Family::ALL.map(|family| (family, None)).to_vec();
        Comparison { array, entries: 0, failures: 0, relative, worst: None, sharp: 0 }
    }

    /// The largest relative error in some families, if any state of theirs is resolved.
    pub fn relative(&self, families: impl Fn(Family) -> bool) -> Option<f64> {
        let errors = self.relative.iter().filter(|(family, _)| families(*family)).filter_map(|(_, x)| *x);
        errors.reduce(f64::max)
    }
}

/// A kernel's derivatives against differences of its own force, both in doubles.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Entries that differences confirm.
    pub agree: usize,
    /// Entries that differences contradict beyond their noise and truncation.
    pub disagree: usize,
    /// Entries that noise and truncation hide.
    pub unresolved: usize,
    /// The contradicted entry that is furthest off; `expected` is the difference.
    pub worst: Option<Entry>,
}

/// What became of an invariant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// The function has the symmetry and so has the kernel.
    Holds,
    /// The function has the symmetry and the kernel has not.
    Violated,
    /// The function has not the symmetry.
    NotInvariant,
    /// The symmetry means nothing for this kind of function.
    NotApplicable,
}

impl Verdict {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Violated => "violated",
            Verdict::NotInvariant => "not invariant",
            Verdict::NotApplicable => "not applicable",
        }
    }
}

/// One invariant.
#[derive(Clone, Debug)]
pub struct Invariant {
    /// Its name.
    pub name: &'static str,
    /// What became of it.
    pub verdict: Verdict,
    /// In which sense, in words; may be empty.
    pub detail: String,
    /// What comes nearest to a violation, or is one.
    pub worst: Option<Entry>,
}

/// One entry of a kernel against the text as it is written.
#[derive(Clone, Debug)]
pub struct TextEntry {
    /// Which: `dfdx[a.ry][b.x]`.
    pub name: String,
    /// The block it belongs to: `dfdx[a.x .. a.rz][b.x .. b.rz]`.
    pub block: String,
    /// What the kernel gives.
    pub kernel: f64,
    /// What the text gives.
    pub text: f64,
    /// What the mathematics gives.
    pub exact: f64,
    /// The error of the kernel, the largest of the block.
    pub error: f64,
    /// The largest error of the text in the block.
    pub text_error: f64,
    /// What is allowed however exact the text is.
    pub allowed: f64,
    /// The error of the kernel in units in the last place of the largest entry of the whole output.
    pub units: f64,
    /// (error − allowed) / text_error, a failure above 4; infinite where the text is finite and the kernel is not.
    pub ratio: f64,
    /// The kind of state.
    pub family: Family,
    /// The state.
    pub inputs: Inputs,
}

/// Blocks that break the rule, of one result and one family.
#[derive(Clone, Copy, Debug, Default)]
pub struct Broken {
    /// How many, over all states.
    pub blocks: usize,
    /// How many of them for a number that is not finite.
    pub lost: usize,
    /// The largest ratio.
    pub ratio: f64,
    /// The largest error in units in the last place of the largest entry of the whole output: no more than a few where a
    /// block is small beside the others and its digits are lost in sums with these.
    pub units: f64,
}

/// A kernel as it is printed against the text as it is written, in one precision.
#[derive(Clone, Debug)]
pub struct TextComparison {
    /// The precision.
    pub precision: Precision,
    /// States that were compared.
    pub states: usize,
    /// Blocks that were compared, over all states.
    pub blocks: usize,
    /// Where the rule is broken.
    pub broken: BTreeMap<(Part, Family), Broken>,
    /// The block with the largest ratio.
    pub worst: Option<TextEntry>,
}

impl TextComparison {
    pub(crate) fn new(precision: Precision) -> TextComparison {
        TextComparison { precision, states: 0, blocks: 0, broken: BTreeMap::new(), worst: None }
    }

    /// Notes a block.
    pub(crate) fn note(
        &mut self,
        array: Part,
        lost: bool,
        ratio: f64,
        most: f64,
        entry: impl Fn() -> TextEntry,
    ) {
        self.blocks += 1;
        if ratio > most {
            let entry = entry();
            let broken = self.broken.entry((array, entry.family)).or_default();
            broken.blocks += 1;
            broken.lost += usize::from(lost);
            broken.ratio = broken.ratio.max(ratio);
            broken.units = broken.units.max(entry.units);
        }
        if self.worst.as_ref().is_none_or(|worst| ratio > worst.ratio) {
            self.worst = Some(entry());
        }
    }

    /// How many blocks break the rule.
    pub fn failures(&self) -> usize {
        self.broken.values().map(|broken| broken.blocks).sum()
    }
}

/// A place where a function branches, and at how many of the compared states each of its arms was active: what it computes was
/// part of the force.
#[derive(Clone, Debug)]
pub struct Branch {
    /// `if`, `min`, `max`, `abs`, `signum`, or `row 2` of a one-sided constraint.
    pub what: String,
    /// Its two arms.
    pub arms: [&'static str; 2],
    /// At how many states each arm was active.
    pub states: [usize; 2],
    /// Where it is in the source, if that is known.
    pub span: Option<Span>,
    /// The line it begins in, where the text is known.
    pub line: Option<usize>,
}

impl Branch {
    /// Its name with its line.
    pub fn name(&self) -> String {
        match self.line {
            Some(line) => format!("{} in line {line}", self.what),
            None => self.what.clone(),
        }
    }

    /// Whether an arm was active at no state.
    pub fn is_uncovered(&self) -> bool {
        self.states.contains(&0)
    }
}

/// The states of one family.
#[derive(Clone, Copy, Debug)]
pub struct Coverage {
    /// The family.
    pub family: Family,
    /// States that were compared.
    pub checked: usize,
    /// States that were redrawn because a value or derivative does not exist there, or a branch is too near.
    pub singular: usize,
    /// Of the compared ones, how many had a force that is not zero.
    pub active: usize,
    /// Of the compared ones, at how many rounding may reach the largest entry of an array: agreement says nothing there.
    pub unresolved: usize,
}

impl Coverage {
    /// Whether enough of the family is regular and resolved to speak of it: a tenth. Beside edges a formula may well be
    /// singular, and arms of branches are counted by themselves.
    pub fn is_covered(&self) -> bool {
        if self.family == Family::Edges {
            return true;
        }
        let told = self.checked - self.unresolved;
        told > 0 && told * 9 >= self.singular + self.unresolved
    }
}

/// All that was found about one kernel.
#[derive(Clone, Debug)]
pub struct Report {
    /// The kernel.
    pub kernel: String,
    /// What the states were drawn from.
    pub seed: u64,
    /// The states.
    pub coverage: Vec<Coverage>,
    /// The branches, and how often each arm was active.
    pub branches: Vec<Branch>,
    /// Whether the author says that some arms are never active.
    pub uncovered_allowed: bool,
    /// The exact oracle.
    pub comparisons: Vec<Comparison>,
    /// Differences in doubles.
    pub differences: Differences,
    /// The text as it is written, in each precision that is printed.
    pub text: Vec<TextComparison>,
    /// The physics.
    pub invariants: Vec<Invariant>,
    /// What keeps the check from saying anything, in words.
    pub problems: Vec<String>,
    /// Whether every comparison holds.
    pub passed: bool,
}

impl Report {
    /// The families that are not covered.
    pub fn not_covered(&self) -> Vec<Family> {
        self.coverage.iter().filter(|c| !c.is_covered()).map(|c| c.family).collect()
    }

    /// Whether every arm of every branch was active at some state, or the author expects otherwise.
    pub fn covers_branches(&self) -> bool {
        self.uncovered_allowed || !self.branches.iter().any(Branch::is_uncovered)
    }

    /// Number of states compared.
    pub fn states(&self) -> usize {
        self.coverage.iter().map(|c| c.checked).sum()
    }

    /// Number of states redrawn.
    #[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
    pub fn singular(&self) -> usize {
        self.coverage.iter().map(|c| c.singular).sum()
    }

    /// The entry that shows best why the check fails: of the exact oracle, then of the differences, then of the physics.
    pub fn worst_failure(&self) -> Option<&Entry> {
        let oracle = self.comparisons.iter().filter(|c| c.failures > 0).filter_map(|c| c.worst.as_ref());
        let oracle = oracle.max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        let differences = || self.differences.worst.as_ref().filter(|_| self.differences.disagree > 0);
        let physics = || {
            let mut violated = self.invariants.iter().filter(|i| i.verdict == Verdict::Violated);
            violated.find_map(|i| i.worst.as_ref())
        };
        oracle.or_else(differences).or_else(physics)
    }
}
