//! Every row of the function table: the derivative formula against differences in 320 bits, the value in
//! doubles against the value in 320 bits, the C and Rust spelling compiled and run, and the edges of the
//! domain.

use forcec::internals::emit;
use forcec::internals::kernel::{File, Kernel, Precision, Target};
use forcec::internals::math::functions::{Function, FunctionDomain};
use forcec::internals::math::special;
use forcec::internals::model::bodies::{Body, BodyKind, Domain, Parameter, ParameterType, Signature};
use forcec::internals::model::outputs::{Output, Part};
use forcec::internals::scalar::{Graph, Program};
use forcec::internals::schedule::meanings::Meanings;
use forcec::internals::schedule::{Style, schedule};
use forcec::internals::verify::Subject;
use forcec::internals::verify::probe::{self, Probe};
use forcec_tests::{Random, compiled, driver, folder, pipe, run};
use std::collections::{BTreeMap, BTreeSet};

const POINTS: [f64; 25] = [
    -40.3, -7.9, -3.7, -1.6, -1.0, -0.9999, -0.77, -0.5, -0.02, -1e-5, -1e-12, 0.0, 1e-12, 1e-5, 0.02, 0.3,
    0.5, 0.77, 0.9999, 1.0, 1.6, 3.7, 12.3, 47.1, 90.1,
];

/// Whether the first argument is a squared length, as in the two families; the function table does not state
/// this restriction.
fn is_family(function: Function) -> bool {
    matches!(function, Function::CosSqrt(_) | Function::AngleRatio(_))
}

/// Whether arguments lie in a domain; on its edge only if `closed`.
fn contains(domain: FunctionDomain, x: &[f64], closed: bool) -> bool {
    let above = |low: f64| if closed { x[0] >= low } else { x[0] > low };
    match domain {
        FunctionDomain::All => true,
        FunctionDomain::AtLeast(low) => above(low),
        FunctionDomain::Above(low) => x[0] > low,
        FunctionDomain::Inside => x[0].abs() < 1.0,
        FunctionDomain::Unit => x[0].abs() < 1.0 || closed && x[0].abs() == 1.0,
        FunctionDomain::NotAllZero => x.iter().any(|x| *x != 0.0),
        FunctionDomain::HalfPlane => above(0.0) && x.iter().any(|x| *x != 0.0),
    }
}

/// All points of a function's domain; of the open interior of both domains for a derivative.
fn points(function: Function, derivative: bool) -> Vec<Vec<f64>> {
    let row = function.row();
    let all: Vec<Vec<f64>> = match row.arity {
        0 => vec![vec![]],
        1 => POINTS.iter().map(|x| vec![*x]).collect(),
        _ => POINTS.iter().flat_map(|x| POINTS.map(|y| vec![*x, y])).collect(),
    };
    let kept = |x: &Vec<f64>| {
        let inside = contains(row.domain, x, !derivative);
        let smooth = !derivative || contains(row.smooth, x, false);
        let family = !is_family(function) || x[0] > 0.0;
        // Near a branch switch the points of a difference lie on both sides.
        let apart = !derivative || !matches!(function, Function::Min | Function::Max) || x[0] != x[1];
        // The angle of a point on the negative axis changes by a turn there.
        let cut = !derivative || function != Function::Atan2 || x[0] != 0.0;
        // 0^y has an edge at y = 0, and the cosine's family has zeros where no relative error is small.
        inside && smooth && family && apart && cut
    };
    all.into_iter().filter(kept).collect()
}

/// Allowed error of a function in units in the last place.
fn units(function: Function) -> f64 {
    match function {
        Function::Abs | Function::Min | Function::Max | Function::Signum => 0.0,
        Function::Pi | Function::Sqrt => 0.5,
        // The error bounds that checks assume.
        Function::CosSqrt(n) | Function::AngleRatio(n) => 8.0 * (1.0 + f64::from(n)),
        _ if special::is_printed(function) => 4.0,
        _ => 2.0,
    }
}

/// Test points for a function implemented by forcec: of every magnitude, and on both sides of every branch
/// switch.
fn sweep(function: Function) -> Vec<Vec<f64>> {
    if is_family(function) || !special::is_printed(function) {
        return points(function, false);
    }
    let mut random = Random::new(3);
    let mut all = POINTS.to_vec();
    for _ in 0..200 {
        let sign = if random.uniform(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        // Magnitudes of floats and of doubles; points where functions bend; points near the ends of domains.
        all.push(sign * 10f64.powf(random.uniform(-37.0, 38.0)));
        all.push(sign * 10f64.powf(random.uniform(-300.0, 300.0)));
        all.push(sign * 10f64.powf(random.uniform(-2.0, 2.0)));
        all.push(sign * (1.0 + 10f64.powf(random.uniform(-15.0, 0.0))));
        all.push(sign * (1.0 - 10f64.powf(random.uniform(-15.0, -1.0))));
        all.push(random.uniform(-3.0, 3.0));
        all.push(random.uniform(-800.0, 800.0));
    }
    let inside = |x: &f64| contains(function.row().domain, &[*x], true);
    all.into_iter().filter(inside).map(|x| vec![x]).collect()
}

/// Allowed error of a function's value at a point in units in the last place. The family of the cosine has
/// zeros; near a zero the last place of the argument limits the accuracy.
fn units_at(function: Function, x: &[f64]) -> f64 {
    let units = units(function);
    if let Function::Sinc(n) = function {
        // `Sinc` has zeros; the terms of the formula are as large as the smaller of 1/(n + 1) and 1/|x|.
        let envelope = (1.0 / f64::from(n + 1)).min(1.0 / x[0].abs());
        return units * (envelope / probe::value(function, x).abs()).max(1.0);
    }
    if !is_family(function) {
        return units;
    }
    let value = probe::value(function, x);
    let partials = probe::partials(function, x).into_iter().zip(x);
    let condition: f64 = partials.map(|(partial, x)| (partial.formula * x / value).abs()).sum();
    units * condition.max(1.0)
}

/// |x − y| in units of the last place of the expected value.
fn units_apart(computed: f64, expected: f64) -> f64 {
    if computed == expected {
        return 0.0;
    }
    (computed - expected).abs() / (expected.abs().next_up() - expected.abs())
}

#[test]
fn derivatives_are_what_differences_say() {
    for function in Function::ALL {
        let points = points(function, true);
        assert!(points.len() >= 5 || function == Function::Pi, "{function:?}: {} points", points.len());
        for x in points {
            for (k, partial) in probe::partials(function, &x).into_iter().enumerate() {
                let size = partial.formula.abs().max(partial.difference.abs());
                // Powers leave the range of doubles; below this size differences have no correct digits left.
                let beyond = !(1e-40..=1e300).contains(&size);
                assert!(
                    partial.apart < 1e-25 || beyond,
                    "∂{}{x:?}/∂{k}: formula `{}` gives {:e}, differences {:e}",
                    function.row().name,
                    function.row().formula,
                    partial.formula,
                    partial.difference
                );
            }
        }
    }
}

#[test]
fn values_are_good_to_a_few_units() {
    for function in Function::ALL {
        let mut worst = (0.0, vec![]);
        for x in sweep(function) {
            let expected = probe::value(function, &x);
            let computed = (function.row().value)(&x);
            if !expected.is_finite() || expected.abs() < f64::MIN_POSITIVE {
                continue;
            }
            let units = units_apart(computed, expected);
            // Half a unit more: the expected value is rounded too.
            let allowed = units_at(function, &x) + 0.5;
            assert!(units <= allowed, "{function:?}: off by {units} of {allowed} units at {x:?}");
            if units > worst.0 {
                worst = (units, x);
            }
        }
        eprintln!("{:14} {:.2} units at {:?}", format!("{function:?}"), worst.0, worst.1);
    }
}

#[test]
fn edges_of_domains_are_where_the_table_says() {
    for function in Function::ALL {
        let row = function.row();
        let edges: &[f64] = match row.domain {
            FunctionDomain::All | FunctionDomain::NotAllZero | FunctionDomain::HalfPlane => continue,
            FunctionDomain::AtLeast(_) | FunctionDomain::Above(_) => &[-1.0],
            FunctionDomain::Unit | FunctionDomain::Inside => &[-1.0, 1.0],
        };
        for &outward in edges {
            let edge = match row.domain {
                FunctionDomain::AtLeast(low) | FunctionDomain::Above(low) => low,
                _ => outward,
            };
            // The exponent of `powf` is not an integer, because integer powers are defined for every base.
            let at = |x: f64| (row.value)(&[x, 0.7][..row.arity]);
            let step =
                |x: f64, inward: bool| if (outward < 0.0) == inward { x.next_up() } else { x.next_down() };
            let outside = at(step(edge, false));
            let derivative = function.order().is_some();
            assert!(outside.is_nan() || derivative, "{function:?} is defined outside of its domain");
            assert!(at(step(edge, true)).is_finite(), "{function:?} is not defined inside of its domain");
            let closed = contains(row.domain, &[edge, 0.7], true);
            assert_eq!(at(edge).is_finite(), closed, "{function:?} at {edge}");
        }
    }
}

/// A kernel for each function, whose first entry of the force is the function of its parameters.
fn kernels() -> Vec<(Function, Kernel)> {
    let kernel = |function: Function| {
        let row = function.row();
        let parameter = |k| Parameter {
            name: format!("x{k}"),
            ty: ParameterType::Real,
            domain: Domain::Any,
            value: None,
        };
        let signature = Signature {
            bodies: vec![Body { name: "p".to_owned(), kind: BodyKind::PARTICLE, fixed: false }],
            parameters: (0..2).map(parameter).collect(),
            rows: 0,
            ..Signature::default()
        };
        let mut graph = Graph::default();
        let zero = graph.zero();
        let x: Vec<_> = (0..row.arity).map(|k| graph.input(signature.parameter_slot(k, 0))).collect();
        let result = graph.call(function, &x);
        let mut program = Program::filled(signature, graph, &Part::DEFAULT, zero);
        program.set(Output::new(Part::Force, 0, 0), result);
        let order = function.order().map(|n| n.to_string()).unwrap_or_default();
        let name = format!("f_{}{order}", row.name.to_lowercase());
        let schedule = schedule(&program, Style::default(), &Meanings::default());
        (function, Kernel::dense(name, vec!["One function.".to_owned()], vec![], schedule))
    };
    Function::ALL.into_iter().map(kernel).collect()
}

#[test]
fn c_and_rust_spell_the_same_function() {
    // The same number of points for all functions: the list of each function is repeated.
    const COUNT: usize = 1425;
    let kernels = kernels();
    let names: BTreeSet<&str> = kernels.iter().map(|(_, kernel)| kernel.name.as_str()).collect();
    assert_eq!(names.len(), Function::ALL.len());
    let file = File {
        stem: "table".to_owned(),
        docs: vec!["The function table.".to_owned()],
        kernels: kernels.iter().map(|(_, kernel)| kernel.clone()).collect(),
        precisions: vec![Precision::F64, Precision::F32],
    };
    let folder = folder(env!("CARGO_TARGET_TMPDIR"), "functions");
    for generated in [Target::C, Target::Rust].into_iter().flat_map(|target| emit::emit(&file, target)) {
        std::fs::write(folder.join(generated.name), generated.text).unwrap();
    }
    std::fs::write(folder.join("driver.c"), driver::c(&file, COUNT)).unwrap();
    std::fs::write(folder.join("driver.rs"), driver::rust(&file, COUNT)).unwrap();
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", "-c", "table.c"];
    run(&folder, "cc", &strict);
    run(&folder, "cc", &["-std=c99", "-O1", "driver.c", "table.o", "-lm", "-o", "in_c"]);
    run(&folder, "rustc", &["--edition", "2024", "-O", "-A", "warnings", "driver.rs", "-o", "in_rust"]);
    let mut input = Vec::new();
    let mut asked = Vec::new();
    for (function, kernel) in &kernels {
        let points = sweep(*function);
        for precision in [Precision::F64, Precision::F32] {
            for point in points.iter().cycle().take(COUNT) {
                let mut x = point.clone();
                if precision == Precision::F32 {
                    let nearest = |x: f64| f64::from((x as f32).clamp(f32::MIN, f32::MAX));
                    x.iter_mut().for_each(|x| *x = nearest(*x));
                    if !contains(function.row().domain, &x, true) {
                        // The point was rounded to the end of the domain.
                        x = vec![0.5; x.len()];
                    }
                }
                input.extend([0.0; 6]);
                input.extend((0..2).map(|k| x.get(k).copied().unwrap_or(0.0)));
                asked.push((
                    *function,
                    precision,
                    x,
                    driver::outputs(&kernel.schedule.signature, &kernel.schedule.parts),
                ));
            }
        }
    }
    let in_c = pipe(&folder.join("in_c"), &input);
    let in_rust = pipe(&folder.join("in_rust"), &input);
    let mut at = 0;
    let mut worst = BTreeMap::new();
    for (function, precision, x, outputs) in asked {
        let (c, rust) = (in_c[at], in_rust[at]);
        at += outputs;
        let expected = probe::value(function, &x);
        let (least, most) = match precision {
            Precision::F64 => (f64::MIN_POSITIVE, f64::MAX),
            Precision::F32 => (f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)),
        };
        if !(least..=most).contains(&expected.abs()) {
            continue;
        }
        let unit = if precision == Precision::F32 { f64::from(f32::EPSILON) } else { f64::EPSILON };
        let allowed = (units_at(function, &x) + 1.0) * unit * expected.abs();
        assert!(
            (c - expected).abs() <= allowed,
            "{function:?}{x:?} is {c:e} in C ({precision}), not {expected:e}"
        );
        let off = |x: f64| (x - expected).abs() / (unit * expected.abs());
        let most = worst.entry((precision, function)).or_insert((0.0f64, 0.0f64));
        *most = (most.0.max(off(c)), most.1.max(off(rust)));
        let alike = if special::is_printed(function) { allowed } else { 2.0 * unit * expected.abs() };
        assert!(
            (rust - c).abs() <= alike,
            "{function:?}{x:?} is {rust:e} in Rust ({precision}) and {c:e} in C"
        );
    }
    assert_eq!(at, in_c.len());
    for ((precision, function), (c, rust)) in worst {
        eprintln!("{precision} {:18} {c:5.2} ε in C, {rust:5.2} ε in Rust", format!("{function:?}"));
    }
}

/// Compares the kernel of a text with the source in 320 bits: the force and ∂F/∂X of a particle, with an
/// error of at most `allowed` ε of the largest entry.
fn compare(name: &str, body: &str, inputs: &[[f64; 3]], allowed: f64) {
    let text = format!("#[energy]\npub fn e(p: Particle) -> Real {{\n    {body}\n}}\n");
    let compiled = compiled(name, &text);
    let function = &compiled.functions[0];
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let mut worst = 0.0f64;
    for position in inputs {
        let mut inputs = vec![0.0; 6];
        inputs[..3].copy_from_slice(position);
        // The reference is the program in 320 bits, which other checks compare with the source, because
        // differences leave noise at tiny values.
        let truth = probe.program(&inputs);
        let computed = function.kernel.schedule.evaluate::<f64>(&|slot| probe.input(&inputs, slot));
        let computed = computed.expect("every output is written");
        let mut expected = truth.as_slice();
        for part in [Part::Force, Part::Dfdx] {
            let entries = computed.part(part);
            let (here, rest) = expected.split_at(entries.len());
            expected = rest;
            let largest = here.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            for (x, y) in entries.iter().zip(here) {
                let off = (x - y).abs() / (largest.max(f64::MIN_POSITIVE) * f64::EPSILON);
                assert!(off <= allowed, "{name} at {position:?}: {part:?} is {x:e}, not {y:e}");
                worst = worst.max(off);
            }
        }
    }
    eprintln!("{name:60} {worst:.2} ε");
}

/// Finite expressions whose intermediate values overflow in the form that authors write, with their
/// derivatives.
#[test]
fn nothing_overflows_on_the_way() {
    let along = |x: f64| [x, 0.3, -0.2];
    let points: Vec<[f64; 3]> =
        [-1e5, -900.0, -300.0, -30.0, -1.1, -0.4, 0.6, 2.0, 40.0, 500.0, 800.0, 1e5].map(along).into();
    for body in [
        "1.0 / (1.0 + x.exp())",
        "1.0 / (1.0 + (-x).exp()).powi(2)",
        "x.exp() / (1.0 + x.exp())",
        "{ let e = (2.0 * x).exp(); let d = 1.0 + e; e / d }",
        "(-x).exp() / (1.0 + (-x).exp()).powi(2)",
        "{ let s = 1.0 / (1.0 + (-x).exp()); s * (1.0 - s) }",
        "(1.0 + x.exp()).ln() / 3.0",
        "(3.0 * x).exp().ln_1p()",
        "(x.exp() - (-x).exp()) / (x.exp() + (-x).exp())",
        "((2.0 * x).exp() - 1.0) / ((2.0 * x).exp() + 1.0)",
        "(1.0 - x.exp()) / (1.0 + x.exp())",
        "1.0 / (x.exp() + (-x).exp())",
        "x.cosh().recip()",
        "x.sinh().recip()",
        "x.cosh() / x.sinh()",
        "x.tanh().powi(3)",
        "x / (x.exp() - 1.0)",
        "x / x.exp_m1()",
        "x.exp() / (x.exp() - 1.0).powi(2)",
        "x.ln_cosh()",
        "x.softplus()",
        "x.logistic()",
    ] {
        compare(body, &format!("let x = p.position.x;\n    {body}"), &points, 512.0);
    }
}

/// Compositions of the table's functions are as accurate as the functions themselves.
#[test]
fn composed_functions_keep_their_digits() {
    let mut points = Vec::new();
    for exponent in -9..3 {
        for mantissa in [1.0, 2.3, -7.7] {
            points.push([mantissa * 10f64.powi(exponent), 0.0, 0.0]);
        }
    }
    compare("versine", "p.position.x.versine()", &points, 16.0);
    // The angle from a fixed direction, squared: near zero, at a right angle, and near π.
    let mut points = Vec::new();
    for small in [0.0, 1e-160, 1e-30, 1e-9, 1e-3, 0.3] {
        points.push([1.0, small, -0.4 * small]);
        points.push([small, 0.7, 0.4]);
        if small > 1e-12 {
            points.push([-1.0, small, 0.1 * small]);
        }
    }
    for angle in ["angle", "angle_between"] {
        compare(angle, &format!("p.position.{angle}(&Vec3::x()).powi(2)"), &points, 64.0);
    }
}
