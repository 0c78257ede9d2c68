//! The results of a check.

use crate::math::number::Precision;
use crate::model::outputs::Part;
use crate::sample::inputs::Inputs;
use crate::sample::states::Family;
use crate::source::span::Span;
use std::collections::BTreeMap;

/// One compared number, with the state.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The entry, such as `dfdx[a.ry][b.x]`.
    pub name: String,
    /// The exact value, rounded.
    pub expected: f64,
    /// The kernel's value.
    pub computed: f64,
    /// The absolute difference, computed before rounding.
    pub error: f64,
    /// The largest error that rounding can cause.
    pub tolerance: f64,
    /// The family of the state.
    pub family: Family,
    /// The state.
    pub inputs: Inputs,
}

impl Entry {
    /// error/tolerance, a failure above 1; infinite if the kernel's value is not finite.
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

/// The comparison of one output with the exact oracle.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The output.
    pub array: Part,
    /// The number of compared entries, over all states.
    pub entries: usize,
    /// The number of entries with an error above the tolerance.
    pub failures: usize,
    /// For each family, the largest error relative to the largest entry of the array, over resolved states;
    /// `None` if no state is resolved.
    pub relative: Vec<(Family, Option<f64>)>,
    /// The entry with the largest ratio of error to tolerance.
    pub worst: Option<Entry>,
    /// The number of states of order one at which rounding leaves at least six digits of the array.
    pub sharp: usize,
}

impl Comparison {
    /// An empty comparison.
    pub(crate) fn new(array: Part) -> Comparison {
        let relative = Family::ALL.map(|family| (family, None)).to_vec();
        Comparison { array, entries: 0, failures: 0, relative, worst: None, sharp: 0 }
    }

    /// The largest relative error in some families; `None` if none of their states is resolved.
    pub fn relative(&self, families: impl Fn(Family) -> bool) -> Option<f64> {
        let errors = self.relative.iter().filter(|(family, _)| families(*family)).filter_map(|(_, x)| *x);
        errors.reduce(f64::max)
    }
}

/// The comparison of a kernel's derivatives with differences of its own force, in doubles.
#[derive(Clone, Debug, Default)]
pub struct Differences {
    /// Entries confirmed by differences.
    pub agree: usize,
    /// Entries that differences contradict by more than noise and truncation.
    pub disagree: usize,
    /// Entries for which noise or truncation are too large.
    pub unresolved: usize,
    /// The contradicted entry with the largest error; `expected` is the difference quotient.
    pub worst: Option<Entry>,
}

/// The outcome of testing an invariant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// The function has the symmetry, and the kernel satisfies it.
    Holds,
    /// The function has the symmetry, and the kernel violates it.
    Violated,
    /// The function does not have the symmetry.
    NotInvariant,
    /// The symmetry is not defined for this kind of function.
    NotApplicable,
}

impl Verdict {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Violated => "violated",
            Verdict::NotInvariant => "not invariant",
            Verdict::NotApplicable => "not applicable",
        }
    }
}

/// The result for one invariant.
#[derive(Clone, Debug)]
pub struct Invariant {
    /// The name in reports.
    pub name: &'static str,
    /// The outcome.
    pub verdict: Verdict,
    /// The sense in which the invariant is tested; may be empty.
    pub detail: String,
    /// The entry that comes closest to a violation, or violates most.
    pub worst: Option<Entry>,
}

/// One entry of a kernel compared with the source as written.
#[derive(Clone, Debug)]
pub struct TextEntry {
    /// The entry, such as `dfdx[a.ry][b.x]`.
    pub name: String,
    /// The block of the entry, such as `dfdx[a.x .. a.rz][b.x .. b.rz]`.
    pub block: String,
    /// The kernel's value.
    pub kernel: f64,
    /// The value of the source as written.
    pub text: f64,
    /// The exact value.
    pub exact: f64,
    /// The error of the kernel, the largest in the block.
    pub error: f64,
    /// The largest error of the source in the block.
    pub text_error: f64,
    /// The error that is allowed even if the source is exact.
    pub allowed: f64,
    /// The error of the kernel in units in the last place of the largest entry of the whole output.
    pub units: f64,
    /// (error − allowed) / text_error, a failure above 4; infinite if only the kernel's value is not finite.
    pub ratio: f64,
    /// The family of the state.
    pub family: Family,
    /// The state.
    pub inputs: Inputs,
}

/// The failing blocks of one output in one family.
#[derive(Clone, Copy, Debug, Default)]
pub struct Broken {
    /// The number of failing blocks, over all states.
    pub blocks: usize,
    /// The number of blocks that fail because an entry is not finite.
    pub lost: usize,
    /// The largest ratio.
    pub ratio: f64,
    /// The largest error in units in the last place of the output's largest entry: small if the block is much
    /// smaller than the others and loses its digits in sums with them.
    pub units: f64,
}

/// The comparison of a printed kernel with its source as written, in one precision.
#[derive(Clone, Debug)]
pub struct TextComparison {
    /// The precision.
    pub precision: Precision,
    /// The number of compared states.
    pub states: usize,
    /// The number of compared blocks, over all states.
    pub blocks: usize,
    /// The failures per output and family.
    pub broken: BTreeMap<(Part, Family), Broken>,
    /// The block with the largest ratio.
    pub worst: Option<TextEntry>,
}

impl TextComparison {
    pub(crate) fn new(precision: Precision) -> TextComparison {
        TextComparison { precision, states: 0, blocks: 0, broken: BTreeMap::new(), worst: None }
    }

    /// Records a block.
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

    /// The number of failing blocks.
    pub fn failures(&self) -> usize {
        self.broken.values().map(|broken| broken.blocks).sum()
    }
}

/// A branch of a function, and the number of compared states at which each arm contributed to the force.
#[derive(Clone, Debug)]
pub struct Branch {
    /// `if`, `min`, `max`, `abs`, `signum`, or `row 2` of a one-sided constraint.
    pub what: String,
    /// The names of the two arms.
    pub arms: [&'static str; 2],
    /// The number of states at which each arm was active.
    pub states: [usize; 2],
    /// The source position, if known.
    pub span: Option<Span>,
    /// The line on which the branch begins, if the source text is available.
    pub line: Option<usize>,
}

impl Branch {
    /// The name with the line.
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

/// The state counts of one family.
#[derive(Clone, Copy, Debug)]
pub struct Coverage {
    /// The family.
    pub family: Family,
    /// The number of compared states.
    pub checked: usize,
    /// States redrawn because a value or derivative does not exist, or a branch is too near.
    pub singular: usize,
    /// Compared states with a nonzero force.
    pub active: usize,
    /// Compared states at which the tolerance exceeds the largest entry of an array: agreement proves
    /// nothing.
    pub unresolved: usize,
}

impl Coverage {
    /// Whether at least a tenth of the family's states are regular and resolved. Always true for `Edges`:
    /// formulas may be singular next to edges, and arms of branches are counted separately.
    pub fn is_covered(&self) -> bool {
        if self.family == Family::Edges {
            return true;
        }
        let resolved = self.checked - self.unresolved;
        resolved > 0 && resolved * 9 >= self.singular + self.unresolved
    }
}

/// The results for one kernel.
#[derive(Clone, Debug)]
pub struct Report {
    /// The name of the kernel.
    pub kernel: String,
    /// The seed of the states.
    pub seed: u64,
    /// The states per family.
    pub coverage: Vec<Coverage>,
    /// The branches, and the number of states at which each arm was active.
    pub branches: Vec<Branch>,
    /// Whether the source allows arms that are never active.
    pub uncovered_allowed: bool,
    /// Comparisons with the exact oracle.
    pub comparisons: Vec<Comparison>,
    /// Comparisons with differences in doubles.
    pub differences: Differences,
    /// Comparisons with the source as written, for each printed precision.
    pub text: Vec<TextComparison>,
    /// The invariants.
    pub invariants: Vec<Invariant>,
    /// Reasons for which the check proves nothing.
    pub problems: Vec<String>,
    /// Whether all comparisons pass.
    pub passed: bool,
}

impl Report {
    /// The families that are not covered.
    pub fn not_covered(&self) -> Vec<Family> {
        self.coverage.iter().filter(|c| !c.is_covered()).map(|c| c.family).collect()
    }

    /// Whether every arm of every branch was active at some state, or the source allows inactive arms.
    pub fn covers_branches(&self) -> bool {
        self.uncovered_allowed || !self.branches.iter().any(Branch::is_uncovered)
    }

    /// The number of compared states.
    pub fn states(&self) -> usize {
        self.coverage.iter().map(|c| c.checked).sum()
    }

    /// The number of redrawn states.
    #[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
    pub fn singular(&self) -> usize {
        self.coverage.iter().map(|c| c.singular).sum()
    }

    /// The entry that best shows the failure, of the oracle, of the differences, or of the invariants.
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
