//! Single precision far from the origin: positions are subtracted before anything else happens, so the error of the force
//! does not grow with the distance.

use forcec::bodies::Slot;
use forcec::compile::Stages;
use forcec::outputs::Part;
use forcec::verify::Subject;
use forcec::verify::probe::Probe;
use forcec_tests::{Random, library};

/// Where `a.position` and `b.position` stand among the inputs of a kernel between two rigid bodies.
const POSITIONS: [usize; 2] = [0, 13];

/// A ball joint with arms of about 0.3 m, off by about 1 cm; every number is a float. Positions are multiples of 2⁻⁹ m, so
/// that they stay the same floats' difference when both are moved by 1e4 m.
fn state(random: &mut Random) -> Vec<f64> {
    let grid = |x: f64| (x * 512.0).round() / 512.0;
    let mut state = Vec::new();
    for _ in 0..2 {
        state.extend((0..3).map(|_| grid(random.uniform(-1.0, 1.0))));
        let q: Vec<f64> = (0..4).map(|_| random.uniform(-1.0, 1.0)).collect();
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        state.extend(q.iter().map(|x| x / norm));
        state.extend((0..6).map(|_| random.uniform(-1.0, 1.0)));
    }
    // arm_a is drawn; arm_b reaches the anchor on a up to the violation: qb⁻¹ (xa + qa arm_a + violation − xb).
    let arm_a: Vec<f64> = (0..3).map(|_| random.uniform(-0.3, 0.3)).collect();
    let anchor = rotate(&state[3..7], &arm_a);
    let arm_b: Vec<f64> = (0..3).map(|_| random.uniform(-0.3, 0.3)).collect();
    let reach = rotate(&state[16..20], &arm_b);
    for k in 0..3 {
        let violation = random.uniform(-0.01, 0.01);
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
    let force = &exact[..signature.freedoms()];
    let largest = force.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let errors = force.iter().zip(computed.part(Part::Force)).map(|(x, y)| (x - f64::from(*y)).abs());
    errors.fold(0.0, f64::max) / largest
}

#[test]
fn floats_do_not_care_how_far_the_origin_is() {
    let files = library();
    let functions = files.iter().flat_map(|file| &file.compiled.functions);
    let mut functions = functions.filter(|function| function.definition.name == "point_to_point");
    let function = functions.next().expect("the library has a ball joint");
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let mut random = Random::new(11);
    let (mut near, mut far) = (0.0f64, 0.0f64);
    for _ in 0..1024 {
        let state = state(&mut random);
        near = near.max(error(function, &probe, &state));
        let mut moved = state.clone();
        for at in POSITIONS {
            for k in 0..3 {
                moved[at + k] += 1e4;
                assert_eq!(f64::from(moved[at + k] as f32), moved[at + k], "the moved position is a float");
            }
        }
        assert_eq!(moved[13] - moved[0], state[13] - state[0]);
        far = far.max(error(function, &probe, &moved));
    }
    eprintln!("near {near:.3e}, far {far:.3e}: {:.3} times", far / near);
    assert!(near > 1e-8, "the error near the origin is that of floats, not {near:e}");
    assert!(far <= 2.0 * near, "{far:e} at 1e4 m, {near:e} near the origin");
}
