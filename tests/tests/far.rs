//! Independence of the origin: for kernels that do not depend on the origin, the error far from the origin is
//! at most twice the error near it, in floats and in doubles. Moved states have bit-identical differences of
//! positions, so every lost digit is a fault of the kernel.

use forcec::internals::compile::Stages;
use forcec::internals::math::number::Number;
use forcec::internals::model::bodies::{Domain, Parameter, ParameterType};
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Subject};

use forcec_tests::{ForceFile, Places, compiled, library, parallel, unseen};

/// How far, in metres.
const DISTANCES: [f64; 3] = [1e4, 1e5, 1e6];

/// Positions are multiples of this number, which floats can represent even a million metres away.
const GRID: f64 = 1.0 / 16.0;

/// States in which a kernel acts, and how many are drawn for each of them at most.
const STATES: usize = 48;
const PATIENCE: usize = 64;

/// Lower limit of the error of a result, in units of rounding: smaller errors mean no loss.
const ROUNDING: f64 = 1.0;

/// Relative errors of a kernel in one precision, result by result, at inputs exact in this precision.
type Errors = fn(&Stages, &Places, &[f64], &[f64]) -> Option<Vec<f64>>;

/// The largest error of each result relative to its largest entry; `None` where it is not finite.
fn errors<N: Number + Copy + Into<f64>>(
    function: &Stages,
    places: &Places,
    inputs: &[f64],
    exact: &[f64],
    narrow: fn(f64) -> N,
) -> Option<Vec<f64>> {
    let computed = function.kernel.schedule.evaluate::<N>(&|slot| narrow(inputs[places.of(slot)]));
    let computed = computed.expect("every output is written");
    let mut exact = exact.iter();
    let error = |entries: &[N]| {
        let pairs: Vec<(f64, f64)> =
            entries.iter().map(|x| (*x).into()).zip(exact.by_ref().copied()).collect();
        let size = pairs.iter().map(|(_, x)| x.abs()).fold(0.0, f64::max);
        let error = pairs.iter().map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        if size == 0.0 { error } else { error / size }
    };
    let errors: Vec<f64> = computed.0.iter().map(|array| array.entries.as_slice()).map(error).collect();
    errors.iter().all(|x| x.is_finite()).then_some(errors)
}

/// A precision: its name, its unit of rounding, errors in it, and how inputs are rounded.
type Precise = (&'static str, f64, Errors, fn(f64) -> f64);

const PRECISIONS: [Precise; 2] = [
    (
        "f32",
        f32::EPSILON as f64 / 2.0,
        |f, p, i, x| errors::<f32>(f, p, i, x, |x| x as f32),
        |x| f64::from(x as f32),
    ),
    ("f64", f64::EPSILON / 2.0, |f, p, i, x| errors::<f64>(f, p, i, x, |x| x), |x| x),
];

/// The faults of a kernel; `None` if the kernel depends on the origin and cannot be judged. A parameter may
/// be a point of the world, which moves with the bodies.
fn judge(function: &Stages) -> Option<Vec<String>> {
    let signature = &function.program.signature;
    let Places { starts, positions } = Places::new(signature);
    let places = &starts[signature.bodies.len()..];
    let is_point = |p: &Parameter| p.ty == ParameterType::Vector(3) && p.domain == Domain::Any;
    let points = signature.parameters.iter().zip(places).filter(|(parameter, _)| is_point(parameter));
    let points: Vec<usize> = points.map(|(_, places)| places[0]).collect();
    let moved = std::iter::once(positions.clone())
        .chain(points.into_iter().map(|point| [&positions[..], &[point]].concat()));
    moved
        .map(|positions| Places { starts: starts.clone(), positions })
        .find_map(|places| judge_moved(function, &places))
}

/// The same check with the positions in `places` moved.
fn judge_moved(function: &Stages, places: &Places) -> Option<Vec<String>> {
    let name = &function.definition.name;
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let mut wrong = Vec::new();
    for (precision, unit, errors, rounded) in PRECISIONS {
        let parts = function.program.arrays.len();
        let mut near = vec![0.0f64; parts];
        let mut far = vec![[0.0f64; DISTANCES.len()]; parts];
        let mut seen = 0;
        for index in 0..PATIENCE * STATES {
            if seen == STATES {
                break;
            }
            let family = [Family::Random, Family::Rest][index % 2];
            let mut state: Vec<f64> = probe.draw(family, 7, index).into_iter().map(rounded).collect();
            for x in places.positions.iter().flat_map(|&at| at..at + 3) {
                state[x] = (state[x] / GRID).round() * GRID;
            }
            let acts = function.kernel.schedule.evaluate::<f64>(&|slot| state[places.of(slot)]);
            if acts.is_none_or(|outputs| outputs.iter().all(|x| *x == 0.0)) {
                continue;
            }
            let exact = probe.program(&state);
            if !exact.iter().all(|x| x.is_finite()) {
                continue;
            }
            let Some(here) = errors(function, places, &state, &exact) else { continue };
            near.iter_mut().zip(here).for_each(|(worst, error)| *worst = worst.max(error));
            seen += 1;
            for (number, distance) in DISTANCES.iter().enumerate() {
                let mut moved = state.clone();
                for (axis, &at) in places.positions.iter().flat_map(|at| [(0, at), (1, at), (2, at)]) {
                    let before = moved[at + axis];
                    moved[at + axis] += distance * [1.0, -0.75, 0.5][axis];
                    assert_eq!(rounded(moved[at + axis]), moved[at + axis], "a moved position is exact");
                    assert_eq!(moved[at + axis] - distance * [1.0, -0.75, 0.5][axis], before);
                }
                if probe.program(&moved) != exact {
                    return None;
                }
                let there = errors(function, places, &moved, &exact).unwrap_or(vec![f64::INFINITY; parts]);
                for (worst, error) in far.iter_mut().zip(there) {
                    worst[number] = worst[number].max(error);
                }
            }
        }
        assert!(seen > STATES / 4, "{name} acts in {seen} states");
        for (array, (near, far)) in function.program.arrays.iter().zip(near.iter().zip(far)) {
            for (distance, error) in DISTANCES.iter().zip(far) {
                if error > 2.0 * near.max(ROUNDING * unit) {
                    let units = near.max(unit) / unit;
                    wrong.push(format!(
                        "{name}: {} in {precision} at {distance:e} m: {:.3e} times the error near the origin, {units:.1} units",
                        array.part, error / near
                    ));
                }
            }
        }
    }
    Some(wrong)
}

#[test]
fn the_origin_may_be_far_away() {
    let weighted = include_str!("../golden/weighted_points.rs");
    let weighted =
        ForceFile { stem: "weighted_points".to_owned(), compiled: compiled("weighted_points", weighted) };
    let files: Vec<ForceFile> = library().into_iter().chain(unseen()).chain([weighted]).collect();
    let functions: Vec<&Stages> = files.iter().flat_map(|file| &file.compiled.functions).collect();
    let names: Vec<&str> = functions.iter().map(|function| function.definition.name.as_str()).collect();
    let judged = parallel(functions, judge);
    let free: Vec<&str> =
        names.iter().zip(&judged).filter(|(_, wrong)| wrong.is_some()).map(|(name, _)| *name).collect();
    let bound: Vec<&&str> = names.iter().filter(|name| !free.contains(*name)).collect();
    eprintln!("{} of {} kernels depend on no origin; the others: {bound:?}", free.len(), names.len());
    assert!(2 * free.len() > names.len(), "most forces depend on no origin: {free:?}");
    let wrong: Vec<String> = judged.into_iter().flatten().flatten().collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
