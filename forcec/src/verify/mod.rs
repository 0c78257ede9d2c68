//! Verifies that a kernel computes the mathematics of its source.
//!
//! In: a force function as written, and its scalar program. Out: a [`Report`], determined by the seed on
//! every platform. At states of nine families the program's outputs are compared with the exact oracle
//! (difference quotients of the source in 320 bits) and with central differences in doubles that estimate
//! their error; and the invariants of the function are tested. The tolerance is a running error bound of the
//! program's operations: rounding cannot fail a check, and no guessed tolerance can hide a wrong sign.

pub(crate) mod big;
mod chosen;
mod differences;
mod dual;
mod invariants;
mod judge;
#[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
mod mutate;
mod oracle;
#[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
pub mod probe;
pub(crate) mod render;
mod report;
mod search;
pub(crate) mod source;
pub(crate) mod tape;
mod written;

#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use crate::sample::inputs::Inputs;
pub use crate::sample::states::Family;
pub use chosen::check_chosen;
#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use judge::Evaluate;
pub use judge::Printed;
#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use mutate::{Mutation, apply, mutate, mutations};
pub use render::{json, table};
#[cfg_attr(not(feature = "internals"), allow(unused_imports, reason = "tests use it"))]
pub use report::{Branch, Broken, Invariant, TextEntry};
pub use report::{Comparison, Coverage, Differences, Entry, Report, TextComparison, Verdict};

use crate::math::random::Random;
use crate::model::bodies::{ParameterType, Role};
use crate::model::outputs::{Output, Part};
use crate::sample::inputs::Places;
use crate::sample::states::{State, draw, excess, seed};
use crate::scalar::{Id, Program};
use crate::source::diagnostic::Lint;
use crate::vector::definition::Definition;
use big::Big;
use differences::Answer;
use invariants::{Invariants, Seen};
use judge::{Judge, Known};
use oracle::{Columns, Oracle, Point, Singular};
use report::ratio;
use search::{Decider, Search};
use std::collections::BTreeMap;
use tape::{Bounded, Tape};

/// A kernel and the source that it is checked against.
pub struct Subject<'a> {
    /// The function as written, in a graph made by [`crate::vector::Graph::verbatim`].
    pub source: &'a Definition,
    /// The program of the kernel.
    pub program: &'a Program,
}

/// The options of a check.
#[derive(Clone, Copy, Debug)]
pub struct CheckOptions {
    /// The seed of the random states.
    pub seed: u64,
    /// The number of states per family.
    pub states: usize,
}

impl Default for CheckOptions {
    fn default() -> CheckOptions {
        CheckOptions { seed: 1, states: 20 }
    }
}

/// Draws per state that must have a force, before one without is accepted; every other state may have none.
const PASSIVE_DRAWS: usize = 40;
/// States per family at which all entries of ∂F/∂X are compared, whatever the cost; others may compare a
/// direction.
const FULL_STATES: usize = 2;
/// The cost limit per kernel for evaluating the source, in 320-bit additions: about a second.
const BUDGET: u64 = 10_000_000;
/// States to try for an arm that no drawn state reached.
const FOUND_STATES: usize = 4;
/// States per family at which equivariance is tested.
const TURNED_STATES: usize = 3;
/// The total number of states is at least that of this many families.
const LEAST_FAMILIES: usize = 5;
/// A state is sharp if all tolerances are below this fraction of the largest entry.
const SHARP: f64 = 1e-6;

/// Checks the program of a kernel.
#[cfg_attr(not(feature = "internals"), allow(dead_code, reason = "tests use it"))]
pub fn check(subject: &Subject, options: &CheckOptions) -> Report {
    check_printed(subject, &[], options)
}

/// Checks the program of a kernel, and the printed kernel in each of these precisions.
pub fn check_printed(subject: &Subject, printed: &[Printed], options: &CheckOptions) -> Report {
    let places = Places::new(&subject.program.signature);
    let oracle = Oracle::new(subject.source, &places);
    let outputs: Vec<Id> = subject.program.outputs().collect();
    let tape = Tape::new(subject.program, &places, &outputs);
    let force = Tape::new(subject.program, &places, subject.program.part(Part::Force));
    let comparisons = Part::DEFAULT.map(Comparison::new);
    let largest = Part::DEFAULT.map(|_| 0.0);
    let mut checker = Checker {
        places: &places,
        oracle: &oracle,
        tape: &tape,
        force: &force,
        names: places.signature.coordinate_names(),
        comparisons: comparisons.to_vec(),
        largest,
        differences: Differences::default(),
        judges: printed.iter().map(|printed| Judge::new(subject, &places, printed)).collect(),
        invariants: Invariants::new(),
        search: Search::new(subject.source, &places, oracle.is_constraint(), options.seed),
        active: BTreeMap::new(),
    };
    let mut coverage: Vec<Coverage> = Vec::new();
    for family in Family::ALL.into_iter().filter(|family| family.applies(&places)) {
        let mut states = Coverage { family, checked: 0, singular: 0, active: 0, unresolved: 0 };
        if family == Family::Edges {
            checker.edges(&mut states, options);
        } else {
            checker.family(&mut states, family.states(options.states), 0, options);
        }
        if family != Family::Edges || states.checked + states.singular > 0 {
            coverage.push(states);
        }
    }
    // Random states replace the missing states of families that are not covered.
    let least = LEAST_FAMILIES * options.states;
    let checked: usize = coverage.iter().map(|c| c.checked).sum();
    let random = &mut coverage[Family::Random as usize];
    if checked < least && random.is_covered() {
        checker.family(random, options.states + least - checked, 1 << 20, options);
    }
    checker.report(subject, options, coverage)
}

struct Checker<'a> {
    places: &'a Places,
    oracle: &'a Oracle<'a>,
    tape: &'a Tape,
    force: &'a Tape,
    names: Vec<String>,
    comparisons: Vec<Comparison>,
    /// The largest entry of each array at earlier states.
    largest: [f64; 3],
    differences: Differences,
    judges: Vec<Judge<'a>>,
    invariants: Invariants,
    search: Search<'a>,
    /// For each arm of a branch, the number of states where it was active.
    active: BTreeMap<(Decider, bool), usize>,
}

/// The exact values at one state.
struct Exact<'o, 'd> {
    point: Point<'o, 'd>,
    dfdv: Columns,
    /// All columns, or one column along `direction`.
    dfdx: Columns,
    direction: Option<Vec<f64>>,
}

/// The exact outputs, in the order of a default kernel's outputs.
fn known(point: &Point, dfdx: Option<&Columns>, dfdv: &Columns) -> Known {
    Known {
        results: vec![Some(point.force.clone()), dfdx.map(Columns::by_row), Some(dfdv.by_row())],
        noise: point.noise,
        edges: point.has_edges(),
    }
}

/// The positions in the inputs where quaternions begin.
pub(crate) fn quaternions(places: &Places) -> Vec<usize> {
    let bodies = 0..places.signature.bodies.len();
    let mut starts: Vec<usize> = bodies.filter_map(|body| places.field(body, Role::Orientation)).collect();
    for (p, parameter) in places.signature.parameters.iter().enumerate() {
        let mut element = &parameter.ty;
        while let ParameterType::Array(_, inner) = element {
            element = inner;
        }
        if *element == ParameterType::Quaternion {
            let length = parameter.ty.length() as usize;
            starts.extend((0..length).step_by(4).map(|k| places.parameter(p) + k));
        }
    }
    starts
}

/// Input errors: the deviation of quaternions from length one.
pub(crate) fn input_errors(places: &Places, values: &[f64]) -> Vec<f64> {
    let mut errors = vec![0.0; values.len()];
    for at in quaternions(places) {
        let excess = excess(&values[at..at + 4]).abs();
        for k in at..at + 4 {
            errors[k] = excess * values[k].abs();
        }
    }
    errors
}

impl<'a> Checker<'a> {
    /// Checks states of a family until `states` are regular, or nine in ten are singular; draws are numbered
    /// from `number`. If regular states are rare, states are moved to where the function is defined.
    fn family(&mut self, coverage: &mut Coverage, states: usize, number: u64, options: &CheckOptions) {
        let family = coverage.family;
        let mut passive = 0;
        let mut number = number;
        while coverage.checked < states && coverage.checked + coverage.singular < 10 * states {
            number += 1;
            let mut random = Random::new(seed(options.seed, family, number));
            let mut state =
                draw(self.places, self.oracle.is_constraint(), family, coverage.checked, &mut random);
            if coverage.singular >= states && 4 * coverage.checked <= coverage.singular {
                // A far state must stay far from the origin when it is moved.
                let found = self.search.regular(&state, &mut random);
                state = found.filter(|found| family != Family::Far || self.is_far(found)).unwrap_or(state);
            }
            let may_pass = coverage.checked.is_multiple_of(2) && passive < PASSIVE_DRAWS * states;
            passive += usize::from(!self.one(coverage, &state, may_pass, &mut random, options));
        }
    }

    /// Whether every body is further from the origin than in states of order one.
    fn is_far(&self, state: &State) -> bool {
        let distance = |at: usize| state.values[at..at + 3].iter().map(|x| x * x).sum::<f64>().sqrt();
        let positions = (0..self.places.signature.bodies.len())
            .filter_map(|body| self.places.field(body, Role::Position));
        let length = self.places.signature.scale.length.unwrap_or(1.0);
        positions.map(distance).all(|distance| distance > 1e3 * length)
    }

    /// Checks one state or counts it as singular. Without a force and with `may_pass`, does neither: `false`.
    fn one(
        &mut self,
        coverage: &mut Coverage,
        state: &State,
        may_pass: bool,
        random: &mut Random,
        options: &CheckOptions,
    ) -> bool {
        let (family, index) = (coverage.family, coverage.checked);
        let full = index < FULL_STATES || self.oracle.cost() * (6 * options.states as u64) <= BUDGET;
        let Ok(point) = self.oracle.unit_point(state) else {
            coverage.singular += 1;
            return true;
        };
        let pushes = point.pushes();
        if !pushes && may_pass {
            return false;
        }
        let Ok(exact) = self.exact(point, full, random) else {
            coverage.singular += 1;
            return true;
        };
        let run = self.tape.values(&state.values);
        if exact.point.has_edges() && !run.outputs.iter().all(|x| x.is_finite()) {
            coverage.singular += 1;
            return true;
        }
        coverage.checked += 1;
        coverage.active += usize::from(pushes);
        for arm in exact.point.branches() {
            *self.active.entry(arm).or_default() += 1;
        }
        let resolved = self.state(family, index, state, &exact, random);
        coverage.unresolved += usize::from(!resolved);
        self.judge(family, state, &exact);
        true
    }

    /// Checks states on arms that no drawn state reached, and states next to edges and zeros of formulas.
    fn edges(&mut self, coverage: &mut Coverage, options: &CheckOptions) {
        let mut random = Random::new(seed(options.seed, Family::Edges, 0));
        let deciders = self.search.deciders();
        for arm in deciders.iter().flat_map(|decider| [(*decider, true), (*decider, false)]) {
            if self.active.contains_key(&arm) {
                continue;
            }
            for state in self.search.find(arm.0, arm.1, FOUND_STATES, &mut random) {
                self.one(coverage, &state, false, &mut random, options);
                if self.active.contains_key(&arm) {
                    break;
                }
            }
        }
        for state in self.search.edges(&deciders, options.states) {
            self.one(coverage, &state, false, &mut random, options);
        }
    }

    /// Compares the printed kernels with the source as written, at the state rounded to their precision.
    fn judge(&mut self, family: Family, state: &State, exact: &Exact<'a, 'a>) {
        let full = exact.direction.is_none();
        let oracle = self.oracle;
        let known = |state: &State| {
            let point = oracle.unit_point(state).ok()?;
            let dfdx = if full { Some(point.dfdx().ok()?) } else { None };
            Some(known(&point, dfdx.as_ref(), &point.dfdv().ok()?))
        };
        for judge in &mut self.judges {
            let Some(own) = judge.state(state) else { continue };
            let truth = if own.values == state.values {
                Some(self::known(&exact.point, full.then_some(&exact.dfdx), &exact.dfdv))
            } else {
                known(&own)
            };
            if let Some(truth) = truth {
                judge.see(family, &own, &truth, &known);
            }
        }
    }

    fn exact(
        &self,
        point: Point<'a, 'a>,
        full: bool,
        random: &mut Random,
    ) -> Result<Exact<'a, 'a>, Singular> {
        let dfdv = point.dfdv()?;
        if full {
            let dfdx = point.dfdx()?;
            return Ok(Exact { point, dfdv, dfdx, direction: None });
        }
        let sign = |random: &mut Random| if random.chance(2) { 1.0 } else { -1.0 };
        let along = self.places.pose.iter().map(|coordinate| {
            sign(random) * random.uniform(0.5, 1.0) * 2f64.powi(self.oracle.shift(coordinate))
        });
        let direction: Vec<f64> = along.collect();
        let dfdx = point.dfdx_along(&direction)?;
        Ok(Exact { point, dfdv, dfdx, direction: Some(direction) })
    }

    /// Compares at one state; returns whether the tolerances leave any digits in every array.
    fn state(
        &mut self,
        family: Family,
        index: usize,
        state: &State,
        exact: &Exact,
        random: &mut Random,
    ) -> bool {
        let n = self.names.len();
        let errors = input_errors(self.places, &state.values);
        let outputs = self.tape.bounds(&state.values, &errors);
        let (force, matrices) = outputs.split_at(n);
        let (dfdx, dfdv) = matrices.split_at(n * n);
        let column = std::slice::from_ref(&exact.point.force);
        let mut resolved = self.compare(Part::Force, family, state, force, column, exact.point.noise);
        resolved &= self.compare(Part::Dfdv, family, state, dfdv, &exact.dfdv.columns, exact.dfdv.noise);
        let along = exact.direction.as_ref().map(|direction| self.along(direction, dfdx, &exact.dfdx));
        resolved &= match along {
            None => self.compare(Part::Dfdx, family, state, dfdx, &exact.dfdx.columns, exact.dfdx.noise),
            // If a direction shows an error, the comparison of entries names the entry.
            Some((false, _)) => match exact.point.dfdx() {
                Ok(all) => self.compare(Part::Dfdx, family, state, dfdx, &all.columns, all.noise),
                Err(_) => {
                    self.comparisons[place(Part::Dfdx)].failures += 1;
                    false
                }
            },
            Some((true, resolved)) => {
                self.comparisons[place(Part::Dfdx)].entries += n;
                resolved
            }
        };
        for (array, coordinates, derivative) in
            [(Part::Dfdx, &self.places.pose, dfdx), (Part::Dfdv, &self.places.velocity, dfdv)]
        {
            let answers = differences::compare(self.force, self.places, state, coordinates, derivative);
            for (at, answer) in answers.into_iter().enumerate() {
                self.difference(array, family, state, at, derivative[at], answer);
            }
        }
        let seen = Seen {
            oracle: self.oracle,
            places: self.places,
            tape: self.tape,
            names: &self.names,
            point: &exact.point,
            state,
            family,
            outputs: &outputs,
            errors: &errors,
        };
        self.invariants.see(&seen, (index < TURNED_STATES).then_some(random));
        resolved
    }

    /// The name of an entry.
    fn name(&self, array: Part, row: usize, column: usize) -> String {
        Output::new(array, row, column).named(&self.places.signature)
    }

    /// Compares an array entry by entry; `kernel` is row by row, `exact` column by column. Returns whether
    /// the array is resolved: whether the tolerance is below the largest entry.
    fn compare(
        &mut self,
        array: Part,
        family: Family,
        state: &State,
        kernel: &[Bounded],
        exact: &[Vec<Big>],
        noise: f64,
    ) -> bool {
        let width = exact.len();
        let sizes = exact.iter().flatten().map(|x| x.to_f64().abs()).filter(|x| *x > noise);
        let largest = sizes.fold(0.0, f64::max);
        // 2⁻⁶⁰ of the largest entry covers the truncation error of the oracle, which is far smaller.
        let slack = noise + largest * 2f64.powi(-60);
        let (mut widest, mut furthest) = (0.0f64, 0.0f64);
        let here = Here { places: self.places, family, state };
        for (column, exact) in exact.iter().enumerate() {
            for (row, exact) in exact.iter().enumerate() {
                let computed = kernel[row * width + column];
                let comparison = &mut self.comparisons[place(array)];
                let output = Output::new(array, row, column);
                let (error, tolerance) = here.compare(comparison, output, exact, computed, slack);
                widest = widest.max(tolerance);
                furthest = furthest.max(error);
            }
        }
        if family.is_ordinary() && widest <= SHARP * largest + slack {
            self.comparisons[place(array)].sharp += 1;
        }
        // If all entries are zero, errors are relative to the largest entry at earlier states.
        let measure = if largest > 0.0 { largest } else { self.largest[place(array)] };
        self.largest[place(array)] = self.largest[place(array)].max(largest);
        let resolved = furthest.is_finite() && widest <= measure + slack;
        if resolved {
            let relative = if furthest == 0.0 { 0.0 } else { furthest / measure };
            let of_family = &mut self.comparisons[place(array)].relative[family as usize].1;
            *of_family = Some(of_family.map_or(relative, |before| before.max(relative)));
        }
        resolved
    }

    /// Whether ∂F/∂X along a direction agrees within the tolerances of its entries, and whether the
    /// tolerances are below the largest entry.
    fn along(&self, direction: &[f64], kernel: &[Bounded], exact: &Columns) -> (bool, bool) {
        let n = direction.len();
        let column = &exact.columns[0];
        let largest = column.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
        let slack = exact.noise + largest * 2f64.powi(-60);
        let mut widest = 0.0f64;
        let agrees = column.iter().enumerate().all(|(row, exact)| {
            let mut sum = Big::zero();
            let mut tolerance = slack;
            for (entry, t) in kernel[row * n..(row + 1) * n].iter().zip(direction) {
                sum = sum + Big::from_f64(entry.value) * Big::from_f64(*t);
                tolerance += entry.error * t.abs() * 1.001;
            }
            widest = widest.max(tolerance);
            (exact.clone() - sum).to_f64().abs() <= tolerance
        });
        (agrees, widest <= largest.max(self.largest[place(Part::Dfdx)]) + slack)
    }

    fn difference(
        &mut self,
        array: Part,
        family: Family,
        state: &State,
        at: usize,
        kernel: Bounded,
        answer: Answer,
    ) {
        match answer {
            Answer::Agrees => self.differences.agree += 1,
            Answer::Unresolved => self.differences.unresolved += 1,
            Answer::Contradicts(value, tolerance) => {
                self.differences.disagree += 1;
                let error = (value - kernel.value).abs();
                let here = ratio(error, tolerance);
                if self.differences.worst.as_ref().is_none_or(|worst| here > worst.ratio()) {
                    let n = self.names.len();
                    self.differences.worst = Some(Entry {
                        name: self.name(array, at / n, at % n),
                        expected: value,
                        computed: kernel.value,
                        error,
                        tolerance,
                        family,
                        inputs: self.places.inputs(&state.values),
                    });
                }
            }
        }
    }

    fn report(self, subject: &Subject, options: &CheckOptions, coverage: Vec<Coverage>) -> Report {
        let invariants = self.invariants.finish(self.oracle, self.places);
        let text: Vec<TextComparison> = self.judges.into_iter().map(Judge::finish).collect();
        let mut problems = Vec::new();
        let covered = coverage.iter().filter(|c| c.is_covered());
        let active: usize = covered.clone().map(|c| c.active).sum();
        if covered.count() == 0 {
            problems.push("no family has regular states: nothing was checked".to_owned());
        } else if active == 0
            && !subject.program.part(Part::Force).iter().all(|id| subject.program.graph.is_zero(*id))
        {
            problems
                .push("no state was found at which a force is not zero: only zeros were checked".to_owned());
        }
        let ordinary = coverage.iter().any(|c| c.family.is_ordinary() && c.is_covered());
        for comparison in self.comparisons.iter().filter(|c| ordinary && c.sharp == 0) {
            problems.push(format!(
                "rounding may reach a millionth of {} at every state of order one: the kernel loses too many digits \
                 to be checked",
                comparison.array
            ));
        }
        let failures: usize = self.comparisons.iter().map(|c| c.failures).sum();
        let violated = invariants.iter().any(|i| i.verdict == Verdict::Violated);
        let worse = text.iter().any(|text| text.failures() > 0);
        let passed =
            problems.is_empty() && failures == 0 && self.differences.disagree == 0 && !violated && !worse;
        Report {
            kernel: subject.source.name.clone(),
            seed: options.seed,
            coverage,
            branches: self.search.branches(subject.source, &self.active),
            uncovered_allowed: subject.source.allowed.contains(&Lint::Uncovered),
            comparisons: self.comparisons,
            differences: self.differences,
            text,
            invariants,
            problems,
            passed,
        }
    }
}

/// The state at which entries are compared.
struct Here<'a> {
    places: &'a Places,
    family: Family,
    state: &'a State,
}

impl Here<'_> {
    /// Compares one entry. Returns the error, zero if within the slack, and the tolerance.
    fn compare(
        &self,
        comparison: &mut Comparison,
        output: Output,
        exact: &Big,
        computed: Bounded,
        slack: f64,
    ) -> (f64, f64) {
        let mut error = (exact.clone() - Big::from_f64(computed.value)).to_f64().abs();
        if !error.is_finite() {
            error = f64::INFINITY;
        }
        let tolerance = computed.error * 1.001 + slack;
        comparison.entries += 1;
        // A kernel that returns NaN has an infinite bound too.
        comparison.failures += usize::from(error.is_infinite() || error > tolerance);
        if comparison.worst.as_ref().is_none_or(|worst| ratio(error, tolerance) > worst.ratio()) {
            comparison.worst = Some(Entry {
                name: output.named(&self.places.signature),
                expected: exact.to_f64(),
                computed: computed.value,
                error,
                tolerance,
                family: self.family,
                inputs: self.places.inputs(&self.state.values),
            });
        }
        (if error <= slack { 0.0 } else { error }, tolerance)
    }
}

/// The position of an array among the compared arrays.
fn place(array: Part) -> usize {
    Part::DEFAULT.iter().position(|part| *part == array).expect("one of the arrays that are compared")
}
