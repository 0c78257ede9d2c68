//! Whether a kernel equals the mathematics of its source.
//!
//! In: a force function as it was written, and the scalar program made of it. Out: a [`Report`], the same for the same
//! seed on every machine. At every state of nine families the program's outputs are compared with the exact oracle
//! (differences of the source in 320 bits), with central differences in doubles that know their noise, and with
//! the invariants that the function has. The tolerance is a running error bound on the program's operations, so
//! that rounding never fails a check and a wrong sign never hides behind a guess.

pub(crate) mod big;
mod chosen;
mod differences;
mod dual;
mod invariants;
mod judge;
#[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
mod mutate;
mod oracle;
#[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
pub mod probe;
pub(crate) mod render;
mod report;
mod search;
pub(crate) mod source;
pub(crate) mod tape;
mod written;

#[cfg_attr(not(feature = "internals"), expect(unused_imports, reason = "tests use it"))]
pub use crate::sample::inputs::Inputs;
pub use crate::sample::states::Family;
pub use chosen::check_chosen;
#[cfg_attr(not(feature = "internals"), expect(unused_imports, reason = "tests use it"))]
pub use judge::Evaluate;
pub use judge::Printed;
#[cfg_attr(not(feature = "internals"), expect(unused_imports, reason = "tests use it"))]
pub use mutate::{Mutation, apply, mutate, mutations};
pub use render::{json, table};
#[cfg_attr(not(feature = "internals"), expect(unused_imports, reason = "tests use it"))]
pub use report::{Branch, Broken, Invariant, TextEntry};
pub use report::{Comparison, Coverage, Differences, Entry, Report, TextComparison, Verdict};

use crate::model::bodies::{ParameterType, Role};
use crate::model::outputs::{Output, Part};
use crate::sample::inputs::Places;
use crate::sample::states::{Random, State, draw, excess, seed};
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

/// What is checked against what.
pub struct Subject<'a> {
    /// The function as it was written, in a graph made by [`crate::vector::Graph::verbatim`].
    pub source: &'a Definition,
    /// What the kernel computes.
    pub program: &'a Program,
}

/// How to check.
#[derive(Clone, Copy, Debug)]
pub struct CheckOptions {
    /// What the states are drawn from.
    pub seed: u64,
    /// How many states of each family.
    pub states: usize,
}

impl Default for CheckOptions {
    fn default() -> CheckOptions {
        CheckOptions { seed: 1, states: 20 }
    }
}

/// Draws for one state before one without force will do: at every other state something should push.
const PASSIVE_DRAWS: usize = 40;
/// States a family whose ∂F/∂X is compared entry by entry however dear that is; others may be compared along a direction.
const FULL_STATES: usize = 2;
/// What evaluations of the source may cost a kernel, in additions of 320 bits: about a second.
const BUDGET: u64 = 10_000_000;
/// States that are tried on an arm that drawn states missed.
const FOUND_STATES: usize = 4;
/// States a family at which the turned state is compared.
const TURNED_STATES: usize = 3;
/// As many states are checked in all as this many families have.
const LEAST_FAMILIES: usize = 5;
/// A state is sharp if no tolerance exceeds this part of the largest entry.
const SHARP: f64 = 1e-6;

/// Checks what a kernel computes.
#[cfg_attr(not(feature = "internals"), expect(dead_code, reason = "tests use it"))]
pub fn check(subject: &Subject, options: &CheckOptions) -> Report {
    check_printed(subject, &[], options)
}

/// Checks what a kernel computes, and the kernel as it is printed in each of these precisions.
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
    // What uncovered families leave out, random states make up for.
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
    /// The largest entry of each array at the states before.
    largest: [f64; 3],
    differences: Differences,
    judges: Vec<Judge<'a>>,
    invariants: Invariants,
    search: Search<'a>,
    /// At how many states each arm of a branch was active.
    active: BTreeMap<(Decider, bool), usize>,
}

/// The mathematics of one state.
struct Exact<'o, 'd> {
    point: Point<'o, 'd>,
    dfdv: Columns,
    /// Every column, or one along a direction.
    dfdx: Columns,
    direction: Option<Vec<f64>>,
}

/// The truth in the order of a whole kernel's outputs.
fn known(point: &Point, dfdx: Option<&Columns>, dfdv: &Columns) -> Known {
    Known {
        results: vec![Some(point.force.clone()), dfdx.map(Columns::by_row), Some(dfdv.by_row())],
        noise: point.noise,
        edges: point.has_edges(),
    }
}

/// Where the quaternions among the inputs begin.
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

/// How far inputs may be from what they stand for: the bits of a quaternion from length one.
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
    /// Checks states of a family until so many are regular, or nine in ten are singular; draws count from `number`. Where hardly
    /// a state is regular, states are moved to where the function has a value.
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
                // A far state that is regular near the origin only is no far state.
                let found = self.search.regular(&state, &mut random);
                state = found.filter(|found| family != Family::Far || self.is_far(found)).unwrap_or(state);
            }
            let may_pass = coverage.checked.is_multiple_of(2) && passive < PASSIVE_DRAWS * states;
            passive += usize::from(!self.one(coverage, &state, may_pass, &mut random, options));
        }
    }

    /// Whether every body is further from the origin than states of order one.
    fn is_far(&self, state: &State) -> bool {
        let distance = |at: usize| state.values[at..at + 3].iter().map(|x| x * x).sum::<f64>().sqrt();
        let positions = (0..self.places.signature.bodies.len())
            .filter_map(|body| self.places.field(body, Role::Position));
        let length = self.places.signature.scale.length.unwrap_or(1.0);
        positions.map(distance).all(|distance| distance > 1e3 * length)
    }

    /// Checks one state, or counts it as singular. Nothing of either where no force acts and `may_pass` is: then `false`.
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

    /// Checks states on the arms that drawn states missed, and beside the edges of every branch and zeros of formulas.
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

    /// Compares the kernels with the text as it is written, at the state as their precision holds it.
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

    /// Compares at one state; whether agreement there says anything about every array.
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
            // Where a direction shows an error, the entries name it.
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

    /// Compares an array entry by entry; the kernel's stands row by row, the exact one column by column. Whether it is
    /// resolved: whether the tolerance leaves anything of the largest entry.
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
        // 2⁻⁶⁰ of the largest stands for the truncation of the oracle's own quotients, which is far smaller.
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
        // Where everything is zero, what is large elsewhere is the measure.
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

    /// Whether ∂F/∂X along a direction is the exact one, within the tolerances of its entries; whether that says
    /// anything.
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

/// Where entries are compared.
struct Here<'a> {
    places: &'a Places,
    family: Family,
    state: &'a State,
}

impl Here<'_> {
    /// Compares one entry and notes what is found. Its error, zero if the slack explains it, and what else does.
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
        // A kernel that returns no number has an infinite bound as well.
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

/// Where an array stands among those that are compared.
fn place(array: Part) -> usize {
    Part::DEFAULT.iter().position(|part| *part == array).expect("one of the arrays that are compared")
}
