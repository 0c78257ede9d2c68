//! Values known at compile time reduce the computation without a change of results. For every library
//! function each body is fixed in turn, and each parameter set to a value; the remaining entries are those of
//! the general kernel. The choice of results has no effect either: any two results are checked together.

use forcec::internals::compile::{Request, Stages, compile_file};
use forcec::internals::math::exact::Exact;
use forcec::internals::model::bodies::Signature;
use forcec::internals::model::outputs::{Axis, Part};
use forcec::internals::source::span::Source;
use forcec::internals::syntax;
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{CheckOptions, Family, Subject, check_chosen};
use forcec::{Effort, Plan, Specialization};
use forcec_tests::{ForceFile, library, parallel, requested};

fn subject(function: &Stages) -> Subject<'_> {
    Subject { source: &function.source, program: &function.program }
}

/// Every single specialization: one fixed body if there are several, or one parameter with its value from a
/// state.
fn ways(signature: &Signature, state: &[f64]) -> Vec<Specialization> {
    let mut ways = Vec::new();
    if signature.bodies.len() > 1 {
        for body in &signature.bodies {
            ways.push(Specialization { fixed: vec![body.name.clone()], ..Specialization::default() });
        }
    }
    let stored = |body: &forcec::internals::model::bodies::Body| {
        body.kind.row().fields.iter().map(|f| f.length as usize).sum::<usize>()
    };
    let mut at: usize = signature.bodies.iter().map(stored).sum();
    for parameter in &signature.parameters {
        let length = parameter.ty.length() as usize;
        let value = state[at..at + length].iter().map(|x| Exact::from_f64(*x).unwrap()).collect();
        ways.push(Specialization { set: vec![(parameter.name.clone(), value)], ..Specialization::default() });
        at += length;
    }
    ways
}

/// Largest error of the special kernel relative to the general kernel, in units of the largest entry of the
/// array.
fn furthest(general: &Stages, special: &Stages, states: usize) -> f64 {
    let subjects = [subject(general), subject(special)];
    let [general, special] = [Probe::new(&subjects[0]), Probe::new(&subjects[1])];
    let signature = &subjects[1].program.signature;
    let mut moves = Vec::new();
    for body in &signature.bodies {
        moves.extend(std::iter::repeat_n(!body.fixed, body.kind.dofs()));
    }
    let n = moves.len();
    let kept: Vec<usize> = (0..n).filter(|k| moves[*k]).collect();
    let kept = kept.as_slice();
    let mut furthest = 0.0f64;
    for index in 0..states {
        let inputs = special.draw(Family::Random, 7, index);
        let (all, some) = (general.program(&inputs), special.program(&inputs));
        let rows = kept.iter().copied();
        let block = |start: usize| kept.iter().flat_map(move |r| kept.iter().map(move |c| start + r * n + c));
        let entries = rows.chain(block(n)).chain(block(n + n * n));
        let expected: Vec<f64> = entries.map(|entry| all[entry]).collect();
        assert_eq!(expected.len(), some.len());
        let size = expected.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (x, y) in expected.iter().zip(&some) {
            if x.is_finite() && size > 0.0 {
                furthest = furthest.max((x - y).abs() / size);
            }
        }
    }
    furthest
}

/// Every function of a file in every specialization: the differences from the general kernel.
fn differences(file: &ForceFile) -> Vec<String> {
    let mut differences = Vec::new();
    let tree = syntax::parse(&file.compiled.source).expect("the library parses");
    for general in &file.compiled.functions {
        let name = &general.definition.name;
        let subject = subject(general);
        let state = Probe::new(&subject).draw(Family::Random, 3, 0);
        for known in ways(&general.program.signature, &state) {
            let compiled = compile_file(
                &tree,
                &|wanted| wanted == name,
                Request { known: known.clone(), ..Request::default() },
            );
            let compiled = compiled.unwrap_or_else(|errors| panic!("{name}, {known:?}:\n{errors}"));
            let special = &compiled.functions[0];
            let apart = furthest(general, special, 3);
            // All values are computed in 320 bits and rounded once.
            if apart > 1e-14 {
                differences.push(format!("{name}, {known:?}: {apart:e}"));
            }
            let (all, fewer) = (general.kernel.schedule.operations(), special.kernel.schedule.operations());
            // Reactions and the last node's blocks cost nothing, so little may be saved, and the search may
            // find a worse result.
            if 20 * fewer.total() > 21 * all.total() {
                differences.push(format!(
                    "{name}, {known:?}: {} of {} operations",
                    fewer.total(),
                    all.total()
                ));
            }
        }
    }
    differences
}

#[test]
fn special_kernels_are_parts_of_the_general_ones() {
    let differences: Vec<String> =
        parallel(library(), |file| differences(&file)).into_iter().flatten().collect();
    assert!(differences.is_empty(), "{differences:#?}");
}

/// Kernels with two results are checked, for all files with functions that have both results.
#[test]
fn results_do_not_disturb_each_other() {
    let choices: Vec<Part> = Part::choices().map(|row| row.part).collect();
    let choices = choices.as_slice();
    let pairs = choices
        .iter()
        .enumerate()
        .flat_map(|(k, first)| choices[k + 1..].iter().map(move |second| vec![*first, *second]));
    let checked = parallel(pairs.collect(), |outputs: Vec<Part>| {
        let of_rows = outputs.iter().any(|part| part.row().rows == Axis::Row);
        let of_constraints = outputs.iter().any(|part| part.row().of_constraints);
        let stems = match (of_constraints, of_rows) {
            (true, _) => &["joints", "cloth", "contacts"][..],
            (_, true) => &["springs", "solids", "cloth"],
            _ => &["joints", "solids", "fields"],
        };
        let plan = Plan { effort: Effort::Quick, ..Plan::default() };
        let mut checked = 0;
        for stem in stems {
            let request = Request { outputs: outputs.clone(), ..Request::from(plan) };
            for function in requested(stem, request).compiled.functions {
                let report = check_chosen(&subject(&function), &[], &CheckOptions { seed: 1, states: 1 });
                assert!(report.passed, "{outputs:?}:\n{}", report.table());
                checked += 1;
            }
        }
        checked
    });
    assert!(checked.iter().all(|&functions| functions > 9), "{checked:?}");
}

#[test]
fn known_values_are_not_arguments() {
    let text = "#[constraint] fn rope(p: Particle, q: Particle, length: Real, at: Vec3) -> Real { \
                (p.position + at - q.position).norm_squared() - length }";
    let tree = syntax::parse(&Source::new("rope.rs", text)).unwrap();
    let known = Specialization {
        fixed: vec!["q".to_owned()],
        set: [("at", "at=[0, 0, 1]"), ("damping", "damping=0")]
            .map(|(_, text)| Specialization::parse_value(text).unwrap())
            .to_vec(),
    };
    let compiled = compile_file(&tree, &|_| true, Request { known, ..Request::default() }).unwrap();
    let kernel = &compiled.functions[0].kernel;
    assert_eq!(kernel.name, "rope_fixed_q_set_at_damping");
    let parameters = kernel.schedule.signature.given().map(|(_, parameter)| parameter.name.as_str());
    assert_eq!(parameters.collect::<Vec<_>>(), ["length", "stiffness"]);
    assert_eq!(kernel.schedule.signature.dofs(), 3);
}
