//! Single precision at nearly satisfied joints: mode `accurate` keeps the digits that rounding destroys in
//! other modes.

use forcec::internals::compile::Stages;
use forcec::internals::emit;
use forcec::internals::model::bodies::Slot;
use forcec::internals::model::outputs::Part;
use forcec::internals::verify::Subject;
use forcec::internals::verify::probe::Probe;
use forcec::{Mode, Plan, Precision, Target};
use forcec_tests::{ForceFile, Random, driver, folder, library_with, pipe, run};

/// A ball joint with arms of about 0.3 m and a violation of about `violation`; every number is a float.
/// Positions are multiples of 1/`steps` m.
fn state(random: &mut Random, violation: f64, steps: f64) -> Vec<f64> {
    let grid = |x: f64| (x * steps).round() / steps;
    let mut state = Vec::new();
    for _ in 0..2 {
        state.extend((0..3).map(|_| grid(random.uniform(-1.0, 1.0))));
        let q: Vec<f64> = (0..4).map(|_| random.uniform(-1.0, 1.0)).collect();
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        state.extend(q.iter().map(|x| x / norm));
        state.extend((0..6).map(|_| random.uniform(-1.0, 1.0)));
    }
    // `arm_a` is random; `arm_b` reaches the anchor on a except for the violation: qb⁻¹ (xa + qa arm_a +
    // violation − xb).
    let arm_a: Vec<f64> = (0..3).map(|_| random.uniform(-0.3, 0.3)).collect();
    let anchor = rotate(&state[3..7], &arm_a);
    let arm_b: Vec<f64> = (0..3).map(|_| random.uniform(-0.3, 0.3)).collect();
    let reach = rotate(&state[16..20], &arm_b);
    for k in 0..3 {
        let violation = random.uniform(-violation, violation);
        state[13 + k] = grid(state[k] + anchor[k] - reach[k] + violation);
    }
    state.extend(arm_a);
    state.extend(arm_b);
    state.extend([random.uniform(10.0, 1000.0), random.uniform(0.1, 10.0)]);
    state.into_iter().map(|x| f64::from(x as f32)).collect()
}

/// q·v for a unit quaternion x, y, z, w.
fn rotate(q: &[f64], v: &[f64]) -> Vec<f64> {
    let cross = |a: &[f64], b: &[f64]| {
        vec![a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let once = cross(&q[..3], v);
    let twice = cross(&q[..3], &once);
    (0..3).map(|k| v[k] + 2.0 * (q[3] * once[k] + twice[k])).collect()
}

/// The error of the force in floats, relative to its largest entry.
fn error(function: &Stages, probe: &Probe, inputs: &[f64]) -> f64 {
    let signature = &function.program.signature;
    let place = |slot: Slot| {
        let fields = |argument: usize| match signature.bodies.get(argument) {
            Some(body) => body.kind.row().fields.iter().map(|field| field.length as usize).collect(),
            None => vec![signature.parameters[argument - signature.bodies.len()].ty.length() as usize],
        };
        let before: usize = (0..slot.argument as usize).flat_map(fields).sum();
        before
            + fields(slot.argument as usize)[..slot.field as usize].iter().sum::<usize>()
            + slot.offset as usize
    };
    let computed = function.kernel.schedule.evaluate::<f32>(&|slot| inputs[place(slot)] as f32);
    let computed = computed.expect("every output is written");
    let exact = probe.program(inputs);
    let force: Vec<f64> = computed.part(Part::Force).iter().map(|x| f64::from(*x)).collect();
    apart(&exact[..signature.dofs()], &force)
}

/// Number of states at nearly satisfied joints.
const HELD: usize = 256;

/// In mode `accurate` a nearly satisfied joint gives the right force. The violation is of the size of
/// rounding errors, so the result in every other mode is mostly noise.
#[test]
fn joints_that_almost_hold_are_accurate() {
    for (kernel, allowed) in [("point_to_point", 5e-7), ("distance", 5e-7), ("hinge", 5e-7)] {
        let [balanced, accurate] = [Mode::Balanced, Mode::Accurate].map(|mode| almost_held(kernel, mode));
        eprintln!("{kernel}: balanced {balanced:.2e}, accurate {accurate:.2e}");
        assert!(balanced > 1e-2, "{kernel}: the test is about what rounding spoils, not {balanced:e}");
        assert!(accurate < allowed, "{kernel}: {accurate:e}");
    }
}

/// The largest error of a joint's force in floats, with a violation of about 1e-6 m, at rest because damping
/// would dominate.
fn almost_held(kernel: &str, mode: Mode) -> f64 {
    let file = library_with(Plan { mode, ..Plan::default() }, "joints");
    let mut functions = file.compiled.functions.iter();
    let function = functions.find(|function| function.definition.name == kernel);
    let function = function.expect("the library has the joint");
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let mut random = Random::new(12);
    let mut worst = 0.0f64;
    let mut states = Vec::new();
    for _ in 0..HELD {
        let mut state = state(&mut random, 1e-6, 2f64.powi(30));
        let rest = [7, 8, 9, 10, 11, 12, 20, 21, 22, 23, 24, 25];
        rest.into_iter().for_each(|at| state[at] = 0.0);
        let gains = state.split_off(32);
        let orientations = [state[3..7].to_vec(), state[16..20].to_vec()];
        match kernel {
            // Anchors apart, with the rod length equal to the distance.
            "distance" => {
                let apart: Vec<f64> = (0..3).map(|_| random.uniform(0.2, 0.6)).collect();
                (0..3).for_each(|k| state[13 + k] = f64::from((state[13 + k] + apart[k]) as f32));
                let anchors = [(0, 26), (1, 29)].map(|(body, arm)| {
                    let turned = rotate(&orientations[body], &state[arm..arm + 3]);
                    (0..3).map(|k| state[13 * body + k] + turned[k]).collect::<Vec<f64>>()
                });
                let length = (0..3).map(|k| (anchors[1][k] - anchors[0][k]).powi(2)).sum::<f64>().sqrt();
                state.push(length + random.uniform(-1e-6, 1e-6));
            }
            // The axis of a is perpendicular to two directions of b.
            "hinge" => {
                let inverse: Vec<f64> =
                    orientations[0][..3].iter().map(|x| -x).chain([orientations[0][3]]).collect();
                let own = |v: [f64; 3]| rotate(&orientations[1], &v);
                let axis = rotate(&inverse, &own([1.0, 0.0, 0.0]));
                state.extend(axis);
                state.extend([0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
            }
            _ => {}
        }
        state.extend(gains);
        let state: Vec<f64> = state.into_iter().map(|x| f64::from(x as f32)).collect();
        worst = worst.max(error(function, &probe, &state));
        states.push(state);
    }
    // The same check for the emitted C, for every contraction setting of the compiler.
    if mode == Mode::Accurate {
        worst = worst.max(in_c(&file, kernel, &probe, &states));
    }
    worst
}

/// The largest error of a kernel's force in compiled C, in floats and with contraction.
fn in_c(file: &ForceFile, kernel: &str, probe: &Probe, states: &[Vec<f64>]) -> f64 {
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), &format!("held_{kernel}"));
    let mut printable = file.printable(&[Precision::F32]);
    printable.kernels.retain(|own| own.name == kernel);
    for generated in emit::emit(&printable, Target::C) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
    std::fs::write(folder.join("driver.c"), driver::c(&printable, HELD)).unwrap();
    let flags = ["-std=gnu11", "-ffp-contract=fast", "-O3", "-march=native"];
    run(&folder, "cc", &[&flags[..], &["driver.c", "joints.c", "-lm", "-o", "driver"]].concat());
    let output = pipe(&folder.join("driver"), &states.concat());
    let forces = output.chunks(output.len() / HELD);
    forces
        .zip(states)
        .map(|(computed, state)| apart(&probe.program(state)[..12], computed))
        .fold(0.0, f64::max)
}

/// Error of a force relative to its largest entry.
fn apart(exact: &[f64], computed: &[f64]) -> f64 {
    let largest = exact.iter().map(|x| x.abs()).fold(0.0, f64::max);
    exact.iter().zip(computed).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / largest
}
