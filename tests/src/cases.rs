//! States with the expected results of a kernel, and the errors of computed results.
//!
//! Input: a compiled force function. Output: states of order one from the generator of the check: random
//! states, states at rest, and states with identity orientations; each with F, ∂F/∂X and ∂F/∂V from 320-bit
//! arithmetic.

use crate::{ForceFile, Random, pipe};
use forcec::internals::compile::Stages;
use forcec::internals::kernel::Precision;
use forcec::internals::model::bodies::Signature;
use forcec::internals::model::outputs::Part;
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Inputs, Subject};
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

/// Number of states per kernel and precision.
pub const STATES: usize = 20;

/// The seed of all states.
const SEED: u64 = 7;

/// Number of draws for a one-sided constraint before a state with zero force is accepted.
const PASSIVE_DRAWS: usize = 40;

/// Work limit of the oracle per kernel, in 320-bit additions. Above this limit the program in 320 bits
/// replaces the source as the reference.
const BUDGET: u64 = 10_000_000;

/// States with larger results are rejected, because the outputs leave the range of floats.
const LARGEST: f64 = 1e30;

/// Error of the oracle's one-sided difference quotients relative to their operands: about 2⁻¹⁰⁴. In floats
/// also the allowance for underflow.
const SLACK: f64 = 1e-28;

/// Errors above the tolerance are compared with this factor times the effect of changing the inputs in the
/// last place.
const OF_CONDITION: f64 = 4.0;

/// One state and the expected results.
#[derive(Clone, Debug)]
pub struct Case {
    /// Family of the state.
    pub family: Family,
    /// The arguments in memory order.
    pub inputs: Vec<f64>,
    /// The outputs in memory order.
    pub expected: Vec<f64>,
    /// Bound of the rounding error of each output in doubles.
    pub bounds: Vec<f64>,
}

/// Source of the expected outputs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reference {
    /// The source as written, differentiated by differences in 320 bits.
    Source,
    /// The program in 320 bits; other checks compare the program with the source.
    Program,
}

/// [`STATES`] states of a kernel. In single precision the inputs are rounded to floats first. A rounded
/// quaternion does not have length one, and derivatives may ignore that deviation, so the expected result
/// comes from the program.
pub fn cases(function: &Stages, precision: Precision, reference: Reference) -> Vec<Case> {
    let cases = draw(function, precision, reference, STATES);
    cases.unwrap_or_else(|| panic!("{}: no regular states", function.definition.name))
}

/// `count` states of a kernel, each with the results of its program; `None` if the kernel has no regular
/// states.
pub fn try_cases(function: &Stages, precision: Precision, count: usize) -> Option<Vec<Case>> {
    draw(function, precision, Reference::Program, count)
}

fn draw(function: &Stages, precision: Precision, reference: Reference, count: usize) -> Option<Vec<Case>> {
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let expensive = probe.cost() * STATES as u64 > BUDGET;
    let mut cases = Vec::new();
    let mut draws = 0;
    let mut passive = 0;
    while cases.len() < count {
        let mut family = Family::ALL[[0, 0, 1, 2][cases.len() % 4]];
        if draws > 20 * STATES {
            // A function may be singular at every state at rest, or at every state with identity
            // orientations.
            family = Family::Random;
        }
        if draws >= 60 * STATES + PASSIVE_DRAWS * STATES {
            return None;
        }
        draws += 1;
        let mut inputs = probe.draw(family, SEED, draws);
        let expected = match precision {
            // Where the source is expensive to evaluate, only a few states use the source as the reference.
            Precision::F64 if reference == Reference::Source && (!expensive || cases.len() < 3) => {
                let Some(truth) = probe.truth(&inputs) else { continue };
                if !truth.pushes && cases.len() % 2 == 0 && passive < PASSIVE_DRAWS * STATES {
                    passive += 1;
                    continue;
                }
                truth.outputs
            }
            Precision::F64 => probe.program(&inputs),
            Precision::F32 => {
                inputs.iter_mut().for_each(|x| *x = f64::from(*x as f32));
                probe.program(&inputs)
            }
        };
        let zero = expected.iter().all(|x| *x == 0.0);
        if zero && cases.len() % 2 == 0 && passive < PASSIVE_DRAWS * STATES {
            passive += 1;
            continue;
        }
        if expected.iter().all(|x| x.abs() <= LARGEST) {
            cases.push(Case { family, bounds: probe.bounds(&inputs), inputs, expected });
        }
    }
    Some(cases)
}

/// The error of one result.
#[derive(Clone, Debug)]
pub struct Miss {
    /// Name of the kernel.
    pub kernel: String,
    /// The output array.
    pub array: Part,
    /// The entry of the array with the largest error.
    pub entry: String,
    /// Family of the state.
    pub family: Family,
    /// Expected value of the entry.
    pub expected: f64,
    /// Computed value of the entry.
    pub computed: f64,
    /// The error relative to the largest entry of the array.
    pub relative: f64,
    /// The largest change of the array, relative to its largest entry, when inputs change in the last place;
    /// measured only where the error exceeds the tolerance.
    pub condition: Option<f64>,
    /// The state.
    pub inputs: Inputs,
}

/// Allowed error of an array relative to its largest entry, unless the last place of the inputs has a larger
/// effect.
fn tolerance(precision: Precision) -> f64 {
    match precision {
        Precision::F64 => 1e-13,
        Precision::F32 => 1e-5,
    }
}

/// The entry of each array with the largest error at one state.
pub fn misses(function: &Stages, precision: Precision, case: &Case, computed: &[f64]) -> Vec<Miss> {
    assert_eq!(case.expected.len(), computed.len());
    let slack = SLACK * case.inputs.iter().chain(&case.expected).fold(1.0, |most, x| x.abs().max(most));
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let mut worst: Vec<Miss> = Vec::new();
    for array in function.outputs() {
        let entries: Vec<usize> = (0..computed.len()).filter(|at| probe.name(*at).0 == array).collect();
        let largest = entries.iter().map(|at| case.expected[*at].abs()).fold(0.0, f64::max);
        let miss = |at: usize| {
            let error = (case.expected[at] - computed[at]).abs();
            let relative = match error {
                error if error <= slack => 0.0,
                error if error.is_finite() => error / largest,
                _ => f64::INFINITY,
            };
            Miss {
                kernel: function.definition.name.clone(),
                array,
                entry: probe.name(at).1,
                family: case.family,
                expected: case.expected[at],
                computed: computed[at],
                relative,
                condition: None,
                inputs: probe.inputs(&case.inputs),
            }
        };
        let misses = entries.iter().map(|at| miss(*at));
        let Some(mut miss) = misses.max_by(|x, y| x.relative.total_cmp(&y.relative)) else { continue };
        if miss.relative > tolerance(precision) {
            miss.condition = Some(condition(&probe, precision, case, &entries) / largest);
        }
        worst.push(miss);
    }
    worst
}

/// Runs a program of [`crate::driver`] over all kernels of a file and returns the errors of each kernel.
pub fn compare(
    file: &ForceFile,
    program: &Path,
    precisions: &[Precision],
    reference: Reference,
) -> Vec<(Precision, Miss)> {
    let mut all = Vec::new();
    for function in &file.compiled.functions {
        for &precision in precisions {
            all.push((function, precision, cases(function, precision, reference)));
        }
    }
    let calls = all.iter().flat_map(|(function, _, cases)| cases.iter().map(move |case| (function, case)));
    let input: Vec<f64> =
        calls.flat_map(|(function, case)| given(&function.program.signature, &case.inputs)).collect();
    let output = pipe(program, &input);
    let mut output = output.as_slice();
    let mut found = Vec::new();
    for (function, precision, cases) in &all {
        for case in cases {
            let (here, rest) = output.split_at(case.expected.len());
            output = rest;
            found.extend(misses(function, *precision, case, here).into_iter().map(|miss| (*precision, miss)));
        }
    }
    assert!(output.is_empty(), "{}: the driver writes what was asked for", file.stem);
    found
}

/// The inputs that a kernel receives: all inputs except parameters with a known value.
pub fn given(signature: &Signature, inputs: &[f64]) -> Vec<f64> {
    let fields = signature.bodies.iter().flat_map(|body| body.kind.row().fields);
    let (bodies, mut rest) = inputs.split_at(fields.map(|field| field.length as usize).sum());
    let mut given = bodies.to_vec();
    for parameter in signature.parameters.iter().chain(&signature.extras) {
        let (entries, others) = rest.split_at(parameter.ty.length() as usize);
        given.extend(entries.iter().filter(|_| parameter.value.is_none()));
        rest = others;
    }
    given
}

/// The largest change of some outputs when every nonzero input moves to an adjacent number, up or down at
/// random: the effect of rounding the inputs once, a lower limit of the error in any arithmetic.
fn condition(probe: &Probe, precision: Precision, case: &Case, entries: &[usize]) -> f64 {
    let mut random = Random::new(SEED);
    let before = probe.program(&case.inputs);
    let mut largest = 0.0f64;
    for _ in 0..16 {
        let mut inputs = case.inputs.clone();
        for x in &mut inputs {
            let up = random.uniform(-1.0, 1.0) > 0.0;
            *x = match precision {
                Precision::F64 if up => x.next_up(),
                Precision::F64 => x.next_down(),
                Precision::F32 if up => f64::from((*x as f32).next_up()),
                Precision::F32 => f64::from((*x as f32).next_down()),
            };
        }
        let after = probe.program(&inputs);
        largest = entries.iter().map(|at| (after[*at] - before[*at]).abs()).fold(largest, f64::max);
    }
    largest
}

impl Miss {
    /// Whether the error exceeds `slack` times the tolerance and also the error that rounding the inputs
    /// explains.
    pub fn fails(&self, precision: Precision, slack: f64) -> bool {
        let allowed =
            (slack * tolerance(precision)).max(slack * OF_CONDITION * self.condition.unwrap_or(0.0));
        // A NaN fails.
        self.relative.is_nan() || self.relative > allowed
    }
}

/// Prints the kernels with the largest errors, and panics if an array is off by more than 1e-13 (doubles) or
/// 1e-5 (floats) of its largest entry. An array is only printed, without a panic, if moving the inputs to
/// adjacent numbers changes the array by at least a quarter of the error: such a state is ill-conditioned for
/// every kernel.
pub fn judge(found: &[(Precision, Miss)]) {
    let mut failures = 0;
    for precision in [Precision::F64, Precision::F32] {
        let mut here: Vec<&Miss> = found.iter().filter(|(p, _)| *p == precision).map(|(_, m)| m).collect();
        here.sort_by(|x, y| y.relative.total_cmp(&x.relative));
        let mut seen = BTreeSet::new();
        eprintln!("{precision}, {} arrays compared; the worst kernels:", here.len());
        for miss in here {
            let fails = miss.fails(precision, 1.0);
            failures += usize::from(fails);
            if seen.insert(&miss.kernel) && (seen.len() <= 5 || fails) || miss.condition.is_some() {
                eprintln!("{miss}");
                if fails {
                    eprintln!("{}", miss.inputs);
                }
            }
        }
    }
    assert_eq!(failures, 0, "arrays are off by more than 1e-13 (f64) or 1e-5 (f32) of their largest entry");
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Miss { kernel, entry, relative, expected, computed, family, .. } = self;
        write!(
            f,
            "{kernel:24} {entry:26} {relative:9.2e} of the largest, {computed:e} for {expected:e} ({family})"
        )?;
        match self.condition {
            Some(condition) => write!(f, "; inputs in their last place: {condition:.2e}"),
            None => Ok(()),
        }
    }
}
