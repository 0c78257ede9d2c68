//! Checks kernels with outputs other than force, dfdx and dfdv against the mathematics of their source.
//!
//! In: a function and a program with any outputs. Out: a [`Report`] that compares their entries with the
//! exact oracle at the states of a check, without central differences and invariants.

use crate::math::random::Random;
use crate::sample::inputs::Places;
use crate::sample::states::{Family, State, draw, seed};
use crate::scalar::Id;
use crate::source::diagnostic::Lint;
use crate::verify::judge::{Judge, Known, Printed};
use crate::verify::oracle::Oracle;
use crate::verify::report::{Comparison, Coverage, Differences, Report, TextComparison};
use crate::verify::search::{Decider, Search};
use crate::verify::tape::Tape;
use crate::verify::{CheckOptions, FOUND_STATES, Here, Subject, input_errors};
use std::collections::BTreeMap;

/// Checks every output of the program, and the printed kernel in each of these precisions.
pub fn check_chosen(subject: &Subject, printed: &[Printed], options: &CheckOptions) -> Report {
    let program = subject.program;
    let places = Places::new(&program.signature);
    let oracle = Oracle::new(subject.source, &places);
    let outputs: Vec<Id> = program.outputs().collect();
    let tape = Tape::new(program, &places, &outputs);
    let mut comparisons: Vec<Comparison> =
        program.arrays.iter().map(|array| Comparison::new(array.part)).collect();
    let mut judges: Vec<Judge> =
        printed.iter().map(|printed| Judge::new(subject, &places, printed)).collect();
    let reached = |state: &State| {
        let point = oracle.unit_point(state).ok()?;
        let results = program.arrays.iter().map(|array| point.part(array.part).ok().map(Some));
        let (noise, edges) = (point.noise, point.has_edges());
        Some((Known { results: results.collect::<Option<_>>()?, noise, edges }, point.branches()))
    };
    let known = |state: &State| reached(state).map(|(known, _)| known);
    let mut coverage = Vec::new();
    let mut search = Search::new(subject.source, &places, oracle.is_constraint(), options.seed);
    let mut active: BTreeMap<(Decider, bool), usize> = BTreeMap::new();
    for family in Family::ALL.into_iter().filter(|family| family.applies(&places)) {
        let mut states = Coverage { family, checked: 0, singular: 0, active: 0, unresolved: 0 };
        let wanted = family.states(options.states);
        let mut found: Option<std::vec::IntoIter<State>> =
            (family == Family::Edges).then(|| missed(&mut search, &active, options).into_iter());
        let mut number = 0;
        loop {
            number += 1;
            let mut random = Random::new(seed(options.seed, family, number));
            let state = match &mut found {
                Some(found) => found.next(),
                None if states.checked == wanted || states.checked + states.singular >= 10 * wanted => None,
                None => Some(draw(&places, oracle.is_constraint(), family, states.checked, &mut random)),
            };
            let Some(state) = state else { break };
            let Some((truth, arms)) = reached(&state) else {
                states.singular += 1;
                continue;
            };
            for judge in &mut judges {
                let Some(own) = judge.state(&state) else { continue };
                let moved = (own.values != state.values).then(|| known(&own));
                if let Some(truth) = moved.as_ref().map_or(Some(&truth), Option::as_ref) {
                    judge.see(family, &own, truth, &known);
                }
            }
            states.checked += 1;
            for arm in arms {
                *active.entry(arm).or_default() += 1;
            }
            let computed = tape.bounds(&state.values, &input_errors(&places, &state.values));
            let mut computed = computed.as_slice();
            let here = Here { places: &places, family, state: &state };
            let exact = truth.results.iter().flatten();
            for ((array, exact), comparison) in program.arrays.iter().zip(exact).zip(&mut comparisons) {
                let (entries, rest) = computed.split_at(exact.len());
                computed = rest;
                let largest = exact.iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
                // As in the check of the default outputs: the truncation error of the oracle's quotients.
                let slack = truth.noise + largest * 2f64.powi(-60);
                let mut furthest = 0.0f64;
                for (((output, _), exact), entry) in array.outputs().zip(exact).zip(entries) {
                    let (error, _) = here.compare(comparison, output, exact, *entry, slack);
                    furthest = furthest.max(error);
                }
                if largest > 0.0 && furthest.is_finite() {
                    let of_family = &mut comparison.relative[family as usize].1;
                    *of_family = Some(of_family.unwrap_or(0.0f64).max(furthest / largest));
                }
            }
        }
        if family != Family::Edges || states.checked + states.singular > 0 {
            coverage.push(states);
        }
    }
    let mut problems = Vec::new();
    if !coverage.iter().any(Coverage::is_covered) {
        problems.push("no family has regular states: nothing was checked".to_owned());
    }
    let text: Vec<TextComparison> = judges.into_iter().map(Judge::finish).collect();
    let passed = problems.is_empty()
        && comparisons.iter().all(|comparison| comparison.failures == 0)
        && text.iter().all(|text| text.failures() == 0);
    Report {
        kernel: subject.source.name.clone(),
        seed: options.seed,
        coverage,
        branches: search.branches(subject.source, &active),
        uncovered_allowed: subject.source.allowed.contains(&Lint::Uncovered),
        comparisons,
        differences: Differences::default(),
        text,
        invariants: Vec::new(),
        problems,
        passed,
    }
}

/// States on arms that no drawn state reached, and next to edges.
fn missed(
    search: &mut Search,
    active: &BTreeMap<(Decider, bool), usize>,
    options: &CheckOptions,
) -> Vec<State> {
    let mut random = Random::new(seed(options.seed, Family::Edges, 0));
    let deciders = search.deciders();
    let arms = deciders.iter().flat_map(|decider| [(*decider, true), (*decider, false)]);
    let missed: Vec<(Decider, bool)> = arms.filter(|arm| !active.contains_key(arm)).collect();
    let mut states = Vec::new();
    for (decider, side) in missed {
        states.extend(search.find(decider, side, FOUND_STATES, &mut random));
    }
    states.extend(search.edges(&deciders, options.states));
    states
}
