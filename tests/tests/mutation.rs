//! Checks of the check: a kernel with one flipped sign, at any place, fails, and the report names an entry. A
//! sign whose flip changes no output at any of twenty states has no effect and is skipped.

use forcec::internals::compile::{Request, Stages};
use forcec::internals::kernel::Precision;
use forcec::internals::model::outputs::Part;
use forcec::internals::scalar::Program;
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{self, CheckOptions, Mutation, Subject};
use forcec_tests::cases::{Case, Reference, cases};
use forcec_tests::{ForceFile, library, parallel, requested};

/// Kernels of every kind: with rotations, with a norm, of several rows, one-sided, an energy, a force.
const KERNELS: [&str; 8] =
    ["point_to_point", "spring", "hinge", "distance", "sphere_plane", "pin", "hinge_motor", "gravity"];

/// The number of these in `joints` and `contacts` that are constraints: their rows are flipped, too.
const ROWS: usize = 5;

/// Limit on flipped signs per kernel; of more signs, this number is flipped, evenly spread.
const MOST: usize = 150;

/// Whether the sign matters: some output at some state changes by more than rounding errors.
fn matters(function: &Stages, mutant: &Program, states: &[Case]) -> bool {
    let subject = Subject { source: &function.source, program: mutant };
    let probe = Probe::new(&subject);
    states.iter().any(|case| {
        let computed = probe.program(&case.inputs);
        let mut pairs = case.expected.iter().zip(&computed).zip(&case.bounds);
        pairs.any(|((expected, computed), bound)| {
            let change = (expected - computed).abs();
            change > 2.0 * bound || change.is_nan()
        })
    })
}

/// Results of the mutants of one kernel.
struct Outcome {
    kernel: String,
    caught: usize,
    harmless: usize,
    problems: Vec<String>,
}

fn mutate(function: &Stages) -> Outcome {
    let kernel = function.definition.name.clone();
    let mut outcome = Outcome { kernel, caught: 0, harmless: 0, problems: Vec::new() };
    let states = cases(function, Precision::F64, Reference::Program);
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let outputs = function.outputs();
    let options = CheckOptions { seed: 1, states: 1 };
    let mutations = verify::mutations(&function.program);
    let stride = mutations.len().div_ceil(MOST);
    for mutation in mutations.into_iter().step_by(stride) {
        let mutant = verify::apply(&function.program, mutation);
        if !matters(function, &mutant, &states) {
            outcome.harmless += 1;
            continue;
        }
        let subject = Subject { source: &function.source, program: &mutant };
        let report = match outputs == Part::DEFAULT {
            true => verify::check(&subject, &options),
            false => verify::check_chosen(&subject, &[], &options),
        };
        let named = report.worst_failure().map(|entry| entry.name.clone()).unwrap_or_default();
        if report.passed {
            outcome.problems.push(format!("{mutation:?} passes"));
        } else if !outputs.iter().any(|part| named.starts_with(&format!("{part}["))) {
            outcome.problems.push(format!("{mutation:?} fails and names `{named}`"));
        } else if let Mutation::Output(output) = mutation
            && named != probe.name(output).1
        {
            outcome.problems.push(format!("{mutation:?} is {} and names `{named}`", probe.name(output).1));
        } else {
            outcome.caught += 1;
        }
    }
    outcome
}

#[test]
fn a_flipped_sign_fails_the_check_and_is_named() {
    let rows = ["value", "rate", "jacobian", "drift", "pull", "geometric"];
    let rows = Part::chosen(rows).expect("names of results");
    let rows = ["joints", "contacts"]
        .map(|stem| requested(stem, Request { outputs: rows.clone(), ..Request::default() }));
    let files: Vec<ForceFile> = library().into_iter().chain(rows).collect();
    let functions: Vec<&Stages> = files
        .iter()
        .flat_map(|file| &file.compiled.functions)
        .filter(|function| KERNELS.contains(&function.definition.name.as_str()))
        .collect();
    assert_eq!(functions.len(), KERNELS.len() + ROWS, "the library has every kernel");
    let mut problems = 0;
    for outcome in parallel(functions, mutate) {
        eprintln!("{}: {} caught, {} harmless", outcome.kernel, outcome.caught, outcome.harmless);
        for problem in &outcome.problems {
            eprintln!("{}: {problem}", outcome.kernel);
        }
        assert!(outcome.caught > 0, "{}: some sign matters", outcome.kernel);
        problems += outcome.problems.len();
    }
    assert_eq!(problems, 0, "flipped signs that were not caught and named");
}
