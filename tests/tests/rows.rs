//! The outputs for solvers with multipliers in place of stiffness: values that are known by hand, relations that
//! hold at every state, and what a kernel says about its J.

use forcec::Specialization;
use forcec::internals::compile::{Request, Stages, compile};
use forcec::internals::model::bodies::{Role, Slot};
use forcec::internals::model::outputs::Part;
use forcec::internals::source::span::Source;
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{Family, Subject};
use forcec_tests::{library_text, requested};

/// The constraints of a file of the library with these outputs, one of which only constraints have.
fn constraints(stem: &str, outputs: &[&str], known: Specialization) -> Vec<Stages> {
    let outputs = Part::chosen(outputs.iter().copied()).expect("names of results");
    requested(stem, Request { outputs, known, ..Request::default() }).compiled.functions
}

/// An array of the results of a program.
fn part<'r>(function: &Stages, results: &'r [f64], part: Part) -> &'r [f64] {
    let mut start = 0;
    for array in &function.program.arrays {
        if array.part == part {
            return &results[start..start + array.entries.len()];
        }
        start += array.entries.len();
    }
    panic!("{part} is not computed");
}

fn near(x: f64, y: f64, size: f64) -> bool {
    (x - y).abs() <= 1e-12 * size
}

/// A body `b` with the arm (1, 0, 0) turns at 2 rad/s about z; the other body rests.
#[test]
fn a_ball_joint_is_as_by_hand() {
    let outputs = ["value", "rate", "drift", "pull", "geometric"];
    let joints = constraints("joints", &outputs, Specialization::default());
    let function = joints.iter().find(|joint| joint.definition.name == "point_to_point");
    let function = function.expect("the library has it");
    let rest = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let turning = [&rest[..12], &[2.0]].concat();
    let (arms, gains, multipliers) = ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [5.0, 7.0], [10.0, 20.0, 30.0]);
    let inputs = [&rest, turning.as_slice(), &arms, &gains, &multipliers].concat();
    let subject = Subject { source: &function.source, program: &function.program };
    let results = Probe::new(&subject).program(&inputs);
    assert_eq!(part(function, &results, Part::Value), [1.0, 0.0, 0.0]);
    assert_eq!(part(function, &results, Part::Rate), [0.0, 2.0, 0.0]);
    assert_eq!(part(function, &results, Part::Drift), [-4.0, 0.0, 0.0]);
    let pull = [-10.0, -20.0, -30.0, 0.0, 0.0, 0.0, 10.0, 20.0, 30.0, 0.0, -30.0, 20.0];
    assert_eq!(part(function, &results, Part::Pull), pull);
    // r λᵀ − (r·λ) I for b, and nothing else.
    let mut geometric = [0.0; 144];
    for (row, column, entry) in [(9, 10, 20.0), (9, 11, 30.0), (10, 10, -10.0), (11, 11, -10.0)] {
        geometric[12 * row + column] = entry;
    }
    assert_eq!(part(function, &results, Part::Geometric), geometric);
}

/// The operations of the ball joint by hand: 30 for each arm, 9 for C, 9 for ω × r of each arm, 9 for each ω × (ω × r), 3 for
/// their difference; 12 for each r λᵀ − (r·λ) I and 3 for each r × λ of its products.
#[test]
fn a_ball_joint_takes_the_operations_of_a_kernel_by_hand() {
    for (outputs, by_hand) in [
        (&["value", "jacobian"][..], 69),
        (&["value", "jacobian", "drift"], 69 + 18 + 18 + 3),
        (&["value", "rate", "jacobian", "drift"], 69 + 18 + 9 + 18 + 3),
        (&["pull", "geometric"], 60 + 24 + 6),
    ] {
        let outputs = Part::chosen(outputs.iter().copied()).expect("names of results");
        let known = Specialization::default();
        let request = Request { outputs: outputs.clone(), known, ..Request::default() };
        let source = Source::new("joints.rs", library_text("joints"));
        let compiled = compile(&source, &|name| name == "point_to_point", request);
        let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}"));
        let count = compiled.functions[0].kernel.schedule.operations().total();
        assert!(count <= by_hand, "{outputs:?}: {count} operations, {by_hand} by hand");
    }
}

/// Jᵀ λ at the kernel's own λ is −F; Vᵀ G V = λ·drift; G − Gᵀ = −[p]× for each body's own rotations, with p the torque of
/// Jᵀ λ, and zero elsewhere.
#[test]
fn the_outputs_of_every_constraint_fit_together() {
    let outputs = ["drift", "multiplier", "force", "pull", "geometric"];
    let mut checked = 0;
    for stem in ["joints", "cloth", "contacts", "springs"] {
        for function in &constraints(stem, &outputs, Specialization::default()) {
            let subject = Subject { source: &function.source, program: &function.program };
            let (probe, signature) = (Probe::new(&subject), &function.program.signature);
            let name = &function.definition.name;
            let blocks = signature.pose_blocks();
            let n = signature.dofs();
            for state in 0..10 {
                let mut inputs = probe.draw(Family::Random, 1, state);
                let given = inputs.len() - signature.rows;
                let results = probe.program(&inputs);
                if !results.iter().all(|x| x.is_finite()) {
                    continue;
                }
                let of = |name| part(function, &results, name);
                let (pull, turn) = (of(Part::Pull), |i: usize, j: usize| of(Part::Geometric)[n * i + j]);
                let velocities: Vec<f64> = (signature.velocity_blocks().iter())
                    .filter_map(|block| signature.body_slot(block.body, block.role))
                    .flat_map(|slot| (0..3).map(move |k| Slot { offset: k, ..slot }))
                    .map(|slot| probe.input(&inputs, slot))
                    .collect();
                let places = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
                let terms: Vec<f64> =
                    places().map(|(i, j)| velocities[i] * turn(i, j) * velocities[j]).collect();
                let along = inputs[given..].iter().zip(of(Part::Drift)).map(|(x, y)| x * y);
                let size = terms.iter().map(|x| x.abs()).sum::<f64>().max(1.0);
                assert!(near(terms.iter().sum(), along.sum(), size), "{name}: λ·drift");
                for (i, j) in places() {
                    let (block, axes) = (blocks[i / 3], (i % 3, j % 3));
                    let turns = i / 3 == j / 3 && block.role == Role::Orientation;
                    let across = |k: usize| if turns { pull[i - axes.0 + k] } else { 0.0 };
                    // −[p]×
                    let torque = match axes {
                        (0, 1) | (1, 2) | (2, 0) => across(3 - axes.0 - axes.1),
                        (1, 0) | (2, 1) | (0, 2) => -across(3 - axes.0 - axes.1),
                        _ => 0.0,
                    };
                    let size = turn(i, j).abs() + turn(j, i).abs() + torque.abs() + 1.0;
                    assert!(near(turn(i, j) - turn(j, i), torque, size), "{name}: [{i}][{j}]");
                }
                let multipliers = of(Part::Multiplier).to_vec();
                inputs[given..].copy_from_slice(&multipliers);
                let results = probe.program(&inputs);
                let of = |name| part(function, &results, name);
                let size = of(Part::Force).iter().fold(1.0, |most: f64, x| most.max(x.abs()));
                let pairs = of(Part::Force).iter().zip(of(Part::Pull));
                assert!(pairs.into_iter().all(|(f, p)| near(*f, -p, size)), "{name}: pull at λ");
                checked += 1;
            }
        }
    }
    assert!(checked > 200, "{checked} states");
}

/// The constraints of the library whose rows are differences of anchors, and no others, are said to be such;
/// J itself comes from the source by dual numbers.
#[test]
fn rows_of_anchors_are_recognised() {
    let arm = Specialization::parse_value("arm_a=[0, 0, 0]").expect("a value");
    let special = Specialization { fixed: vec!["b".to_owned()], set: vec![arm] };
    let mut found = Vec::new();
    for (stem, known) in [
        ("joints", Specialization::default()),
        ("joints", special),
        ("springs", Specialization::default()),
        ("cloth", Specialization::default()),
    ] {
        for function in constraints(stem, &["jacobian", "drift"], known) {
            let anchored = function.kernel.anchored.expect("J is an output");
            let subject = Subject { source: &function.source, program: &function.program };
            let probe = Probe::new(&subject);
            let jacobian = probe.text(None, &probe.draw(Family::Random, 1, 0));
            assert_eq!(anchored, is_anchored(&subject, &jacobian), "{}", function.kernel.name);
            found.extend(anchored.then_some(function.kernel.name));
        }
    }
    let special = ["point_to_point_fixed_b_set_arm_a", "pin", "attachment_fixed_b"];
    assert_eq!(found, [&["point_to_point", "pin", "attachment"], &special[..]].concat());
}

/// Whether J has three rows, ±I for each position and an antisymmetric block for each orientation.
fn is_anchored(subject: &Subject, jacobian: &[f64]) -> bool {
    let signature = &subject.program.signature;
    let width = signature.dofs();
    let blocks = signature.pose_blocks();
    signature.rows == 3
        && blocks.iter().enumerate().all(|(k, block)| {
            let entry = |i: usize, j: usize| jacobian[i * width + 3 * k + j];
            let sign = entry(0, 0).signum();
            let fits = |i: usize, j: usize| match block.role {
                Role::Position => entry(i, j) == if i == j { sign } else { 0.0 },
                _ => entry(i, j) == -entry(j, i),
            };
            (0..9).all(|at| fits(at / 3, at % 3))
        })
}
