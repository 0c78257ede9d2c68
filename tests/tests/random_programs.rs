//! Random force files through the whole pipeline: valid programs compute the value of their source, and
//! compile to the same bytes twice.
//!
//! Programs come from a small grammar over two bodies, with every kind of parameter, law and statement, and functions only
//! where they are smooth. `PROPTEST_CASES` raises their number.

use forcec::Plan;
use forcec::internals::compile::compile;
use forcec::internals::emit;
use forcec::internals::kernel::{File, Precision, Target};
use forcec::internals::model::bodies::Role;
use forcec::internals::optimize::{LOWER, PASSES};
use forcec::internals::scalar::{Node, Program};
use forcec::internals::source::span::Source;
use forcec::internals::verify::{self, CheckOptions, Family, Report, Subject, Verdict};
use forcec_tests::{compiled, options_for};
use proptest::prelude::{Just, Strategy, prop_oneof};
use proptest::strategy::BoxedStrategy;
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestError, TestRunner};
use std::collections::BTreeSet;

/// Programs, unless the environment says otherwise.
const CASES: u32 = 64;

fn any(texts: &'static [&'static str]) -> BoxedStrategy<String> {
    proptest::sample::select(texts).prop_map(str::to_owned).boxed()
}

/// A template in which `$0`, `$1` … are replaced by values of strategies.
fn fill<const N: usize>(template: &'static str, parts: [BoxedStrategy<String>; N]) -> BoxedStrategy<String> {
    let parts: Vec<BoxedStrategy<String>> = parts.into();
    let filled = move |parts: Vec<String>| {
        let parts = parts.iter().enumerate();
        parts.fold(template.to_owned(), |text, (k, part)| text.replace(&format!("${k}"), part))
    };
    parts.prop_map(filled).boxed()
}

/// A real expression.
fn real(depth: u32) -> BoxedStrategy<String> {
    let leaf = any(&[
        "0.7",
        "-1.25",
        "3.0",
        "k",
        "s",
        "h[0]",
        "h[2]",
        "m[(0, 1)]",
        "u.y",
        "a.position.x",
        "b.position[2]",
        "c0",
        "c1",
    ]);
    if depth == 0 {
        return leaf;
    }
    let r = || real(depth - 1);
    let v = || vector(depth - 1);
    prop_oneof![
        2 => leaf,
        2 => fill("($0 + $1)", [r(), r()]),
        2 => fill("($0 - $1)", [r(), r()]),
        3 => fill("($0 * $1)", [r(), r()]),
        1 => fill("($0) / (1.5 + ($1).powi(2))", [r(), r()]).prop_map(|text| format!("({text})")).boxed(),
        1 => fill("(-$0)", [r()]),
        1 => fill("($0).sin()", [r()]),
        1 => fill("($0).cos()", [r()]),
        1 => fill("(($0).sin() * 3.0).tanh()", [r()]),
        1 => fill("($0).atan()", [r()]),
        1 => fill("(($0).sin() * 0.9).asin()", [r()]),
        1 => fill("(($0).sin()).exp()", [r()]),
        1 => fill("(0.5 + ($0).powi(2)).ln()", [r()]),
        1 => fill("(0.5 + ($0).powi(2)).sqrt()", [r()]),
        1 => fill("(1.5 + ($0).sin()).powf(1.3)", [r()]),
        1 => fill("($0).hypot(0.4)", [r()]),
        1 => fill("($0).atan2(1.5 + ($1).cos())", [r(), r()]),
        1 => fill("($0).powi(3)", [r()]),
        1 => fill("($0).abs()", [r()]),
        1 => fill("($0).min($1)", [r(), r()]),
        1 => fill("($0).max($1)", [r(), r()]),
        1 => fill("(if $0 < $1 { $2 } else { $3 })", [r(), r(), r(), r()]),
        1 => fill("square($0)", [r()]),
        2 => fill("($0).dot(&$1)", [v(), v()]),
        2 => fill("($0).norm_squared()", [v()]),
        2 => fill("(($0).norm_squared() + 0.1).sqrt()", [v()]),
        1 => fill("($0).norm()", [v()]),
    ]
    .boxed()
}

/// A vector expression.
fn vector(depth: u32) -> BoxedStrategy<String> {
    let leaf = any(&[
        "a.position",
        "b.position",
        "(b.position - a.position)",
        "u",
        "Vec3::y()",
        "(a.orientation * u)",
        "(a.orientation.inverse() * arms[0])",
        "(m * arms[1])",
        "w0",
        "w1",
    ]);
    if depth == 0 {
        return leaf;
    }
    let r = || real(depth - 1);
    let v = || vector(depth - 1);
    prop_oneof![
        3 => leaf,
        2 => fill("($0 + $1)", [v(), v()]),
        2 => fill("($0 - $1)", [v(), v()]),
        2 => fill("($0 * $1)", [v(), r()]),
        1 => fill("(-$0)", [v()]),
        2 => fill("($0).cross(&$1)", [v(), v()]),
        2 => fill("(a.orientation * $0)", [v()]),
        1 => fill("(a.orientation.conjugate() * $0)", [v()]),
        1 => fill("(spin * $0)", [v()]),
        1 => fill("($0).component_mul(&$1)", [v(), v()]),
        1 => fill("(m.transpose() * $0)", [v()]),
        1 => fill("(if $0 < $1 { $2 } else { $3 })", [r(), r(), v(), v()]),
        1 => fill("Vec3::new($0, $1, $2)", [r(), r(), r()]),
        1 => fill("($0 / (1.5 + ($1).norm_squared()))", [v(), v()]),
    ]
    .boxed()
}

/// A whole force function: an attribute, the bodies' types, statements and a result.
fn program() -> BoxedStrategy<String> {
    let body = any(&["Rigid", "Particle"]);
    let statements = prop_oneof![
        Just("    let c0 = 0.3 * s;\n    let c1 = c0 + k;\n".to_owned()).boxed(),
        fill(
            "    let mut c0 = 0.0;\n    for i in 0..3 {\n        c0 += h[i] * $0 + i as Real;\n    }\n    let c1 = c0 * 0.5;\n",
            [any(&["k", "a.position.y", "b.position.x * s", "(u.x * s)"])],
        ),
        fill(
            "    let (c0, c1) = if $0 > 0.1 { (s, $1) } else { ($1, k) };\n",
            [
                any(&["a.position.z", "k", "b.position.dot(&u)"]),
                any(&["a.position.x", "s * k", "u.norm_squared()"])
            ],
        ),
    ];
    let law = prop_oneof![
        3 => fill("#[constraint]|Real|    $0", [real(3)]),
        3 => fill("#[constraint]|Vec3|    $0", [vector(3)]),
        2 => fill("#[constraint]|(Vec3, Real)|    ($0, $1)", [vector(2), real(3)]),
        2 => fill("#[constraint(unilateral)]|(Real, Real)|    ($0, $1)", [real(3), real(2)]),
        1 => fill("#[constraint(per_row)]|(Real, Vec3)|    ($0, $1)", [real(2), vector(2)]),
        3 => fill("#[energy]|Real|    $0", [real(3)]),
        2 => fill(
            "#[force]|(Wrench, $B)|    let f = $0 + (b.velocity - a.velocity) * $1;\n    let t = a.angular_velocity + $2;\n    \
             (Wrench { force: f, torque: t }, $R)",
            [vector(2), real(2), vector(2)],
        ),
    ];
    let lines = (body, statements, vector(1), vector(1), law);
    lines
        .prop_map(|(body, statements, w0, w1, law)| {
            let mut parts = law.splitn(3, '|');
            let mut next = || parts.next().expect("three parts").to_owned();
            let (attribute, returns, result) = (next(), next(), next());
            let rigid = body == "Rigid";
            let returns = returns.replace("$B", if rigid { "Wrench" } else { "Vec3" });
            let back = if rigid { "Wrench { force: -f, torque: f.cross(&u) }" } else { "-f" };
            let result = result.replace("$R", back);
            // The first vectors cannot use names that are not yet defined.
            let w0 = w0.replace("w0", "u").replace("w1", "arms[0]");
            let w1 = w1.replace("w1", "arms[1]");
            format!(
                "fn square(x: Real) -> Real {{\n    x * x\n}}\n\n{attribute}\n#[domain(k = 0.2..2.0, u = unit)]\n\
                 pub fn made(\n    a: Rigid,\n    b: {body},\n    k: Real,\n    s: Real,\n    u: Vec3,\n    \
                 h: [Real; 3],\n    arms: [Vec3; 2],\n    m: Mat3,\n    turn: Quat,\n) -> {returns} {{\n\
                 {statements}    let spin = turn * a.orientation;\n    let w0 = {w0};\n    let w1 = {w1};\n{result}\n}}\n"
            )
        })
        .boxed()
}

/// Every file of every target.
fn emitted(text: &str) -> Vec<emit::Generated> {
    let compiled = compiled("made", text);
    let file = File {
        stem: "made".to_owned(),
        docs: compiled.docs.clone(),
        kernels: compiled.functions.iter().map(|function| function.kernel.clone()).collect(),
        precisions: vec![Precision::F64, Precision::F32],
    };
    [Target::C, Target::Rust].into_iter().flat_map(|target| emit::emit(&file, target)).collect()
}

/// Whether a report shows an error. Far from the origin random programs take sines of millions, which turn
/// many times within one step of a difference in doubles and lose every digit of a force balance, so only the
/// exact oracle counts.
fn is_wrong(report: &Report) -> bool {
    let oracle = report.comparisons.iter().any(|comparison| comparison.failures > 0);
    let violated = report.invariants.iter().filter(|invariant| invariant.verdict == Verdict::Violated);
    let mut worst = violated.map(|invariant| invariant.worst.as_ref());
    let physics = worst.any(|worst| worst.is_none_or(|entry| entry.family != Family::Far));
    let worst = report.differences.worst.as_ref().filter(|_| report.differences.disagree > 0);
    oracle || physics || worst.is_some_and(|entry| entry.family != Family::Far)
}

#[test]
fn random_programs_compute_what_they_say() {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(CASES);
    let config = Config {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(5),
        max_shrink_iters: 200,
        ..Config::default()
    };
    let mut checked = 0;
    let mut unchecked = 0;
    let counts = std::cell::RefCell::new((&mut checked, &mut unchecked));
    let outcome = TestRunner::new(config).run(&program(), |text| {
        let compiled = compiled("made", &text);
        let function = &compiled.functions[0];
        let subject = Subject { source: &function.source, program: &function.program };
        let report = verify::check(&subject, &CheckOptions { seed: 1, states: 2 });
        if is_wrong(&report) {
            return Err(TestCaseError::fail(report.table()));
        }
        let (checked, unchecked) = &mut *counts.borrow_mut();
        // A function that is singular or passive everywhere, or loses all digits, cannot be checked, and the
        // report says so.
        **(if report.passed { checked } else { unchecked }) += 1;
        // Any options give a kernel or a message.
        for seed in 0..4 {
            let options = options_for(&text, seed + 4 * text.len() as u64);
            if let Err(errors) = forcec::compile(&text, &options) {
                assert!(errors.has_errors(), "{text}\n{options:?}");
            }
        }
        if emitted(&text) != emitted(&text) {
            return Err(TestCaseError::fail("the same text compiles to other bytes"));
        }
        Ok(())
    });
    eprintln!("{checked} programs checked, {unchecked} that cannot be");
    match outcome {
        Ok(()) => assert!(unchecked * 4 <= checked, "most programs can be checked"),
        Err(TestError::Fail(reason, text)) => panic!("{reason}\n{text}"),
        Err(abort) => panic!("{abort}"),
    }
}

/// The pinned differences of a program; `None` if the program also subtracts positions elsewhere.
fn pinned(program: &Program) -> Option<BTreeSet<String>> {
    let live = program.live();
    let is_position = |node: &Node| matches!(node, Node::Input(slot) if program.signature.role(*slot) == Some(Role::Position));
    let mut differences = BTreeSet::new();
    for (_, node) in program.graph.iter().filter(|(id, _)| live[id.index()]) {
        match node {
            Node::Difference(first, second) => {
                differences.insert(format!("{first:?} {second:?}"));
            }
            Node::Sum(_, terms) => {
                let points = terms.iter().filter(|(_, term)| is_position(program.graph.node(*term)));
                let signs: BTreeSet<bool> = points.map(|(c, _)| c.is_negative()).collect();
                if signs.len() > 1 {
                    return None;
                }
            }
            _ => {}
        }
    }
    Some(differences)
}

/// Each pass by itself preserves values and pinned differences.
#[test]
fn every_pass_keeps_values_and_pins() {
    let config =
        Config { cases: 12, failure_persistence: None, rng_seed: RngSeed::Fixed(11), ..Config::default() };
    let mut held = 0;
    let count = std::cell::RefCell::new(&mut held);
    let outcome = TestRunner::new(config).run(&program(), |text| {
        let source = Source::new("made.rs", text.as_str());
        let with = |passes: &[&str]| {
            let plan = Plan::from(forcec::Effort::Default).with_passes(passes.iter().copied()).unwrap();
            compile(&source, &|_| true, plan).unwrap_or_else(|errors| panic!("{errors}\n{text}"))
        };
        let lowered = with(&[LOWER]);
        let before = pinned(&lowered.functions[0].program).expect("lowering pins");
        **count.borrow_mut() += before.len();
        for pass in &PASSES {
            let compiled = with(&[pass.name]);
            let function = &compiled.functions[0];
            let subject = Subject { source: &function.source, program: &function.program };
            let report = verify::check(&subject, &CheckOptions { seed: 1, states: 1 });
            if is_wrong(&report) {
                return Err(TestCaseError::fail(format!("{}\n{}", pass.name, report.table())));
            }
            if !pinned(&function.program).is_some_and(|after| after.is_subset(&before)) {
                return Err(TestCaseError::fail(format!("{} opens a pinned difference", pass.name)));
            }
        }
        Ok(())
    });
    if let Err(error) = outcome {
        panic!("{error}");
    }
    assert!(held > 0, "some programs pin differences");
}

/// tanh″ is −2 tanh x / cosh² x. Built as −2 sinh x / cosh³ x it would be ∞ · 0 beyond the range of cosh.
#[test]
fn tanh_of_a_large_number_has_finite_second_derivatives() {
    let text = "#[energy]\npub fn made(p: Particle) -> Real {\n    p.position.x.tanh()\n}\n";
    let compiled = compiled("made", text);
    let schedule = &compiled.functions[0].kernel.schedule;
    let outputs = schedule.evaluate::<f64>(&|_| 800.0).expect("every output is written");
    assert!(outputs.iter().all(|x| x.is_finite()), "{outputs:?}");
}
