//! The verifier on hand-built kernels: correct kernels pass, and every flipped sign is found and named.

use forcec::Precision;
use forcec::internals::kernel::Kernel;
use forcec::internals::math::exact::Exact;
use forcec::internals::math::functions::Function;
use forcec::internals::math::number::Comparison;
use forcec::internals::model::bodies::{
    Body, BodyKind, Domain, Parameter, ParameterType, Role, Signature, Slot,
};
use forcec::internals::model::outputs::Part;
use forcec::internals::scalar::Program;
use forcec::internals::schedule::meanings::Meanings;
use forcec::internals::schedule::{Style, schedule};
use forcec::internals::vector::definition::{Definition, Generalised, Law, Row};
use forcec::internals::vector::{Graph, Real, Vector};
use forcec::internals::verify::probe::Probe;
use forcec::internals::verify::{self, CheckOptions, Family, Mutation, Printed, Report, Subject, Verdict};

const V3: ParameterType = ParameterType::Vector(3);
const REAL: ParameterType = ParameterType::Real;

/// A function for a graph, with or without simplification.
struct Sample {
    name: &'static str,
    bodies: Vec<BodyKind>,
    parameters: Vec<(&'static str, ParameterType, Domain)>,
    law: fn(&mut Graph) -> Law,
}

impl Sample {
    fn signature(&self) -> Signature {
        let names = ["a", "b", "c", "d"];
        let body =
            |(name, kind): (&str, &BodyKind)| Body { name: name.to_owned(), kind: *kind, fixed: false };
        let parameter = |(name, ty, domain): &(&str, ParameterType, Domain)| Parameter {
            name: (*name).to_owned(),
            ty: ty.clone(),
            domain: *domain,
            value: None,
        };
        Signature {
            bodies: names.into_iter().zip(&self.bodies).map(body).collect(),
            parameters: self.parameters.iter().map(parameter).collect(),
            rows: 0,
            ..Signature::default()
        }
    }

    fn definition(&self, mut graph: Graph) -> Definition {
        let law = (self.law)(&mut graph);
        Definition {
            name: self.name.into(),
            docs: vec![],
            span: Default::default(),
            graph,
            law,
            extremes: vec![],
            allowed: vec![],
            singular: vec![],
            branches: vec![],
        }
    }

    fn source(&self) -> Definition {
        self.definition(Graph::verbatim(self.signature()))
    }

    fn program(&self) -> Program {
        let definition = self.definition(Graph::new(self.signature()));
        let derive =
            |formulation| forcec::internals::derive::derive(&definition, &Part::DEFAULT, formulation);
        forcec::internals::optimize::optimize(derive, forcec::Effort::Default.into(), None)
            .expect("it is short")
            .program
    }

    fn check(&self) -> Report {
        verify::check(&Subject { source: &self.source(), program: &self.program() }, &CheckOptions::default())
    }
}

fn rigid(
    name: &'static str,
    parameters: &[(&'static str, ParameterType)],
    law: fn(&mut Graph) -> Law,
) -> Sample {
    sample(name, &[BodyKind::RIGID, BodyKind::RIGID], parameters, law)
}

fn sample(
    name: &'static str,
    bodies: &[BodyKind],
    parameters: &[(&'static str, ParameterType)],
    law: fn(&mut Graph) -> Law,
) -> Sample {
    let parameters = parameters.iter().map(|(name, ty)| (*name, ty.clone(), Domain::Any)).collect();
    Sample { name, bodies: bodies.to_vec(), parameters, law }
}

fn slot(g: &Graph, body: u16, role: Role) -> Slot {
    g.signature.body_slot(body, role).expect("the body stores it")
}

fn position(g: &mut Graph, body: u16) -> Vector {
    let slot = slot(g, body, Role::Position);
    g.triple(slot)
}

fn vector(g: &mut Graph, parameter: usize) -> Vector {
    let slot = g.signature.parameter_slot(parameter, 0);
    g.triple(slot)
}

fn real(g: &mut Graph, parameter: usize) -> Real {
    let slot = g.signature.parameter_slot(parameter, 0);
    g.entry(slot)
}

fn arm(g: &mut Graph, body: u16, parameter: usize) -> Vector {
    let arm = vector(g, parameter);
    let q = slot(g, body, Role::Orientation);
    g.rotate(q, false, arm)
}

/// The anchor on b minus the anchor on a.
fn gap(g: &mut Graph) -> Vector {
    let ends = [0u16, 1].map(|body| {
        let (x, r) = (position(g, body), arm(g, body, body as usize));
        let p = g.vector_add(x, r);
        g.let_vector(["pa", "pb"][body as usize], p)
    });
    g.vector_sub(ends[1], ends[0])
}

fn two_sided(rows: Vec<Row>) -> Law {
    Law::Constraint { rows, unilateral: false, per_row: false }
}

const GAINS: [(&str, ParameterType); 2] = [("stiffness", REAL), ("damping", REAL)];

fn ball() -> Sample {
    let [ks, kd] = GAINS;
    rigid("ball", &[("arm_a", V3), ("arm_b", V3), ks, kd], |g| two_sided(vec![Row::Vector(gap(g))]))
}

fn distance() -> Sample {
    let [ks, kd] = GAINS;
    rigid("distance", &[("arm_a", V3), ("arm_b", V3), ("rest", REAL), ks, kd], |g| {
        let d = gap(g);
        let d = g.let_vector("d", d);
        let (length, rest) = (g.norm(d), real(g, 2));
        two_sided(vec![Row::Real(g.sub(length, rest))])
    })
}

fn hinge() -> Sample {
    let [ks, kd] = GAINS;
    let parameters = [("arm_a", V3), ("arm_b", V3), ("axis", V3), ("n1", V3), ("n2", V3), ks, kd];
    rigid("hinge", &parameters, |g| {
        let d = gap(g);
        let axis = arm(g, 0, 2);
        let axis = g.let_vector("axis", axis);
        let normals = [arm(g, 1, 3), arm(g, 1, 4)];
        let mut rows = vec![Row::Vector(d)];
        rows.extend(normals.map(|n| Row::Real(g.dot(axis, n))));
        two_sided(rows)
    })
}

fn per_row() -> Sample {
    let parameters = [
        ("arm_a", V3),
        ("arm_b", V3),
        ("stiffness", ParameterType::Array(3, Box::new(REAL))),
        ("damping", ParameterType::Array(3, Box::new(REAL))),
    ];
    rigid("per_row", &parameters, |g| Law::Constraint {
        rows: vec![Row::Vector(gap(g))],
        unilateral: false,
        per_row: true,
    })
}

/// The angle between the bodies, by atan2 of the relative rotation's parts.
fn twist() -> Sample {
    let [ks, kd] = GAINS;
    rigid("twist", &[("axis", V3), ("other", V3), ks, kd], |g| {
        let (u, v) = (arm(g, 0, 0), arm(g, 1, 1));
        let c = g.cross(u, v);
        let (sine, cosine) = (g.norm(c), g.dot(u, v));
        two_sided(vec![Row::Real(g.call(Function::Atan2, &[sine, cosine]))])
    })
}

fn spring() -> Sample {
    let [ks, kd] = GAINS;
    sample("spring", &[BodyKind::PARTICLE; 2], &[("rest", REAL), ks, kd], |g| {
        let (a, b) = (position(g, 0), position(g, 1));
        let d = g.vector_sub(b, a);
        let d = g.let_vector("d", d);
        let (length, rest) = (g.norm(d), real(g, 0));
        two_sided(vec![Row::Real(g.sub(length, rest))])
    })
}

/// A particle above a plane through the origin.
fn floor() -> Sample {
    let [ks, kd] = GAINS;
    let mut floor = sample("floor", &[BodyKind::PARTICLE], &[("normal", V3), ks, kd], |g| {
        let (x, n) = (position(g, 0), vector(g, 0));
        Law::Constraint { rows: vec![Row::Real(g.dot(x, n))], unilateral: true, per_row: false }
    });
    floor.parameters[0].2 = Domain::Unit;
    floor
}

fn neo_hookean() -> Sample {
    let parameters =
        [("inverse", ParameterType::Matrix(3)), ("volume", REAL), ("mu", REAL), ("lambda", REAL)];
    sample("neo_hookean", &[BodyKind::PARTICLE; 4], &parameters, |g| {
        let x: Vec<Vector> = (0..4).map(|body| position(g, body)).collect();
        let e: Vec<Vector> = (1..4).map(|i| g.vector_sub(x[i], x[0])).collect();
        let f: Vec<Vector> = (0..3)
            .map(|column| {
                let term = |k: usize, g: &mut Graph| {
                    let slot = g.signature.parameter_slot(0, 3 * k as u32 + column);
                    let entry = g.entry(slot);
                    (Exact::ONE, g.scale(entry, e[k]))
                };
                let terms = (0..3).map(|k| term(k, g)).collect();
                let sum = g.vector_sum(terms);
                g.let_vector("f", sum)
            })
            .collect();
        let squares = (0..3).map(|j| (Exact::ONE, g.dot(f[j], f[j]))).collect();
        let i1 = g.sum(Exact::from(-3), squares);
        let cross = g.cross(f[1], f[2]);
        let j = g.dot(f[0], cross);
        let log = g.call(Function::Ln, &[j]);
        let log = g.let_real("log_j", log);
        let (volume, mu, lambda) = (real(g, 1), real(g, 2), real(g, 3));
        let shear = g.mul(mu, i1);
        let mixed = g.mul(mu, log);
        let bulk = g.product(&[(lambda, 1), (log, 2)]);
        let half = || Exact::ratio(1, 2);
        let psi = g.sum(Exact::ZERO, vec![(half(), shear), (Exact::from(-1), mixed), (half(), bulk)]);
        Law::Energy(g.mul(volume, psi))
    })
}

/// A potential of a rigid body: gravity and a bend of its own axis against the vertical beyond a threshold.
fn tilt() -> Sample {
    sample("tilt", &[BodyKind::RIGID], &[("axis", V3), ("weight", REAL)], |g| {
        let axis = arm(g, 0, 0);
        let x = position(g, 0);
        let (lean, height, weight) = (g.component(axis, 2), g.component(x, 2), real(g, 1));
        let tenth = g.constant(Exact::ratio(1, 10));
        let leans = g.compare(Comparison::Less, tenth, lean);
        let (square, size) = (g.powi(lean, 3), g.call(Function::Abs, &[lean]));
        let bend = g.select(leans, square, size);
        let heavy = g.mul(weight, height);
        Law::Energy(g.add(bend, heavy))
    })
}

/// A drag between two bodies that reads velocities, and a torque.
fn drag() -> Sample {
    sample("drag", &[BodyKind::RIGID, BodyKind::PARTICLE], &[("rate", REAL)], |g| {
        let velocities = [0u16, 1].map(|body| {
            let slot = slot(g, body, Role::Velocity);
            g.triple(slot)
        });
        let spin = slot(g, 0, Role::AngularVelocity);
        let spin = g.triple(spin);
        let slip = g.vector_sub(velocities[1], velocities[0]);
        let (speed, rate) = (g.norm(slip), real(g, 0));
        let strength = g.mul(rate, speed);
        let force = g.scale(strength, slip);
        let axis = slot(g, 0, Role::Orientation);
        let torque = g.rotate(axis, true, spin);
        let back = g.vector_neg(force);
        Law::Force(vec![
            Generalised { force, torque: Some(torque) },
            Generalised { force: back, torque: None },
        ])
    })
}

/// The rotation vector of a body's orientation, 2 A(|u|², w) u for q = (u, w).
fn logarithm() -> Sample {
    let [ks, kd] = GAINS;
    sample("logarithm", &[BodyKind::RIGID], &[ks, kd], |g| {
        let first = slot(g, 0, Role::Orientation);
        let q = [0, 1, 2, 3].map(|offset| g.entry(Slot { offset, ..first }));
        let squares = [0, 1, 2].map(|k| (Exact::ONE, g.powi(q[k], 2)));
        let m = g.sum(Exact::ZERO, squares.to_vec());
        let ratio = g.call(Function::AngleRatio(0), &[m, q[3]]);
        let twice = g.scaled(Exact::from(2), ratio);
        two_sided([0, 1, 2].map(|k| Row::Real(g.mul(twice, q[k]))).to_vec())
    })
}

/// cos |x|, which is smooth at the origin, and a one-sided row together with a two-branched row.
fn ripple() -> Sample {
    sample("ripple", &[BodyKind::PARTICLE; 2], &[("depth", REAL)], |g| {
        let (a, b) = (position(g, 0), position(g, 1));
        let d = g.vector_sub(b, a);
        let (square, depth) = (g.dot(d, d), real(g, 0));
        let wave = g.call(Function::CosSqrt(0), &[square]);
        let (first, second) = (g.component(d, 0), g.component(d, 1));
        let (least, size) = (g.call(Function::Min, &[first, second]), g.call(Function::Abs, &[second]));
        let root = g.call(Function::Hypot, &[least, depth]);
        let heavy = g.product(&[(depth, 1), (root, 2)]);
        Law::Energy(g.sum(
            Exact::ratio(1, 3),
            vec![(Exact::ONE, wave), (Exact::ratio(1, 7), heavy), (Exact::ONE, size)],
        ))
    })
}

/// Two spheres: one-sided, with a gain a row.
fn spheres() -> Sample {
    let parameters = [
        ("radius_a", REAL),
        ("radius_b", REAL),
        ("stiffness", ParameterType::Array(1, Box::new(REAL))),
        ("damping", ParameterType::Array(1, Box::new(REAL))),
    ];
    rigid("spheres", &parameters, |g| {
        let (a, b) = (position(g, 0), position(g, 1));
        let d = g.vector_sub(b, a);
        let (length, first, second) = (g.norm(d), real(g, 0), real(g, 1));
        let gap = g.sum(Exact::ZERO, vec![(Exact::ONE, length), (-Exact::ONE, first), (-Exact::ONE, second)]);
        Law::Constraint { rows: vec![Row::Real(gap)], unilateral: true, per_row: true }
    })
}

fn all() -> Vec<Sample> {
    vec![
        ball(),
        distance(),
        hinge(),
        per_row(),
        twist(),
        spring(),
        floor(),
        neo_hookean(),
        tilt(),
        drag(),
        logarithm(),
        ripple(),
        spheres(),
    ]
}

/// Many seeds: a correct kernel raises no false alarm at any seed.
#[test]
fn no_seed_raises_an_alarm() {
    for seed in 100..102 {
        for sample in all() {
            let (source, program) = (sample.source(), sample.program());
            let options = CheckOptions { seed, ..CheckOptions::default() };
            let report = verify::check(&Subject { source: &source, program: &program }, &options);
            assert!(report.passed, "{}", report.table());
        }
    }
}

#[test]
fn right_kernels_pass() {
    let mut reports = Vec::new();
    for sample in all() {
        let start = std::time::Instant::now();
        reports.push(sample.check());
        println!("{:12} {:?}", sample.name, start.elapsed());
    }
    println!("{}", verify::table(&reports));
    for report in &reports {
        assert!(report.passed, "{}", report.table());
        assert!(report.states() >= 100, "{}", report.table());
        let uncovered: Vec<Family> =
            report.coverage.iter().filter(|c| !c.is_covered()).map(|c| c.family).collect();
        // The norm of the drag's slip is not differentiable at zero slip.
        assert_eq!(uncovered, if report.kernel == "drag" { vec![Family::Rest] } else { vec![] });
    }
}

/// The verdicts on Σ force, Σ torque, equivariance, ∂F/∂V and ∂F/∂X.
fn verdicts(sample: &Sample) -> Vec<(Verdict, String)> {
    let options = CheckOptions { states: 3, ..CheckOptions::default() };
    let report = verify::check(&Subject { source: &sample.source(), program: &sample.program() }, &options);
    report.invariants.into_iter().map(|i| (i.verdict, i.detail)).collect()
}

#[test]
fn physics_is_asked_in_the_right_sense() {
    use Verdict::{Holds, NotApplicable, NotInvariant};
    let check = |sample: Sample, expected: [(Verdict, &str); 5]| {
        let expected = expected.map(|(verdict, detail)| (verdict, detail.to_owned()));
        assert_eq!(verdicts(&sample), expected, "{}", sample.name);
    };
    let (holds, not) = ((Holds, ""), (NotInvariant, ""));
    let at_rest = (Holds, "at damping 0");
    // The damping of a ball joint leaves the torque −d × f.
    check(ball(), [holds, at_rest, holds, holds, at_rest]);
    check(distance(), [holds, holds, holds, holds, at_rest]);
    // Stiffness along the axes of the world depends on directions.
    check(per_row(), [holds, not, not, holds, at_rest]);
    // A floor depends on the direction of gravity.
    check(floor(), [not, not, not, holds, at_rest]);
    check(neo_hookean(), [holds, holds, holds, (NotApplicable, ""), holds]);
    check(tilt(), [(Holds, "along x, y"), (Holds, "along z"), not, (NotApplicable, ""), holds]);
    check(drag(), [holds, not, not, (NotApplicable, ""), (NotApplicable, "")]);
}

/// The report on a kernel with one sign flipped.
fn mutant(source: &Definition, program: &Program, mutation: Mutation) -> Report {
    let mutant = verify::apply(program, mutation);
    verify::check(&Subject { source, program: &mutant }, &CheckOptions { seed: 1, states: 1 })
}

#[test]
fn every_flipped_sign_is_caught() {
    // All signs of the spring, and every seventh sign of the other kernels; all 1,700 signs are found too, in
    // a minute.
    for (sample, stride) in [(spring(), 1), (ball(), 7), (neo_hookean(), 29), (floor(), 1)] {
        let (source, program) = (sample.source(), sample.program());
        for mutation in verify::mutations(&program).into_iter().step_by(stride) {
            let report = mutant(&source, &program, mutation);
            assert!(!report.passed && report.worst_failure().is_some(), "{}: {mutation:?}", sample.name);
        }
    }
}

#[test]
fn a_flipped_entry_is_named() {
    let sample = ball();
    let (source, program) = (sample.source(), sample.program());
    let names = program.signature.coordinate_names();
    let n = names.len();
    for (row, column) in [(4, 6), (9, 3), (0, 11)] {
        let report = mutant(&source, &program, Mutation::Output(n + row * n + column));
        let name = format!("dfdx[{}][{}]", names[row], names[column]);
        let worst = report.comparisons[1].worst.as_ref().expect("something was compared");
        assert_eq!(worst.name, name);
        assert!((worst.expected + worst.computed).abs() <= 1e-9 * worst.expected.abs(), "{worst:?}");
        assert_eq!(report.comparisons[0].failures, 0);
        assert!(report.differences.disagree > 0);
        let table = report.table();
        assert!(table.contains("FAIL") && table.contains(&name), "{table}");
        assert!(table.contains("a.orientation = [") && table.contains("stiffness = "), "{table}");
        assert!(report.json().contains(&format!("\"name\": \"{name}\"")));
    }
}

#[test]
fn the_seed_decides_everything() {
    let sample = distance();
    let (source, program) = (sample.source(), sample.program());
    let subject = Subject { source: &source, program: &program };
    let run = |seed| verify::check(&subject, &CheckOptions { seed, states: 2 }).json();
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

/// The gradient of another function fails, however small the difference.
#[test]
fn another_function_fails() {
    let [ks, kd] = GAINS;
    let near = rigid("ball", &[("arm_a", V3), ("arm_b", V3), ks, kd], |g| {
        let gap = gap(g);
        let longer = Exact::parse("1.000000000001").expect("a literal");
        two_sided(vec![Row::Vector(g.vector_sum(vec![(longer, gap)]))])
    });
    let source = ball().source();
    let report = verify::check(
        &Subject { source: &source, program: &near.program() },
        &CheckOptions { seed: 1, states: 2 },
    );
    assert!(!report.passed);
    // The kernel's own differences and physics are consistent: only the comparison with the source finds the
    // error.
    assert_eq!(report.differences.disagree, 0);
    assert!(report.invariants.iter().all(|i| i.verdict != Verdict::Violated));
}

/// A kernel that returns NaN at a finite value fails, although no error bound detects a NaN.
#[test]
fn nan_fails() {
    let energy = |root: bool| {
        let law: fn(&mut Graph) -> Law = if root {
            |g| {
                let x = position(g, 0);
                let square = g.dot(x, x);
                let opposite = g.neg(square);
                Law::Energy(g.call(Function::Sqrt, &[opposite]))
            }
        } else {
            |g| {
                let x = position(g, 0);
                Law::Energy(g.dot(x, x))
            }
        };
        sample("square", &[BodyKind::PARTICLE], &[], law)
    };
    let (source, program) = (energy(false).source(), energy(true).program());
    let report = verify::check(&Subject { source: &source, program: &program }, &CheckOptions::default());
    assert!(!report.passed && report.comparisons.iter().take(2).all(|c| c.failures == c.entries));
    assert!(report.json().contains("\"NaN\""));
}

/// A function without a regular state gives a message instead of passing.
#[test]
fn nothing_checked_is_a_failure() {
    let nowhere = sample("nowhere", &[BodyKind::PARTICLE], &[], |g| {
        let x = position(g, 0);
        let square = g.dot(x, x);
        let opposite = g.neg(square);
        Law::Energy(g.call(Function::Ln, &[opposite]))
    });
    let report = nowhere.check();
    assert!(!report.passed && report.states() == 0);
    assert!(report.problems[0].contains("nothing was checked"), "{:?}", report.problems);
    assert!(report.table().contains("is not covered"));
}

/// Stiffness up to 1e10: differences in doubles must not raise false alarms.
#[test]
fn stiff_kernels_raise_no_false_alarm() {
    for seed in 0..4 {
        for sample in [ball(), distance(), spring(), neo_hookean()] {
            let (source, program) = (sample.source(), sample.program());
            let options = CheckOptions { seed, states: 6 };
            let report = verify::check(&Subject { source: &source, program: &program }, &options);
            assert!(report.passed, "{}", report.table());
        }
    }
}

/// A kernel from the text of its function, by the whole pipeline, and the report of its check.
fn checked(text: &str) -> Report {
    let source = forcec::internals::source::span::Source::new("force.rs", text);
    let compiled = forcec::internals::compile::compile(&source, &|_| true, forcec::Effort::Default)
        .unwrap_or_else(|errors| panic!("{errors}"));
    let function = &compiled.functions[0];
    let subject = Subject { source: &function.source, program: &function.program };
    verify::check(&subject, &CheckOptions::default())
}

/// A cosine of 10¹¹ and more, whose argument has an error larger than the period: differences over whole
/// periods agree only with each other. Such differences are unresolved, and do not contradict a correct
/// kernel.
#[test]
fn differences_know_periods() {
    for body in
        ["(k * k * p.position.x).cos()", "(1e11 * k * p.position.x).sin()", "(1e9 * p.position.x).tan()"]
    {
        let report =
            checked(&format!("#[force]\nfn wave(p: Particle, k: Real) -> Vec3 {{ p.position * {body} }}\n"));
        assert!(report.passed && report.differences.disagree == 0, "{body}\n{}", report.table());
        assert!(report.differences.agree > 100, "{body}\n{}", report.table());
    }
    let wave =
        "#[force]\nfn wave(p: Particle, k: Real) -> Vec3 { p.position * (1e11 * k * p.position.x).sin() }\n";
    assert!(checked(wave).differences.unresolved > 100);
}

/// Without stiffness a contact at rest lies on the switch between contact and no contact, where the
/// derivative of either side is correct: such states are singular, and the other states are checked.
#[test]
fn states_on_a_switch_are_singular() {
    let rows = "#[constraint(unilateral)]\nfn floor(p: Particle, q: Particle) -> Real { p.position.z - q.position.x }\n";
    let function = "#[force]\nfn ground(p: Particle, k: Real) -> Vec3 { let push = (-k * p.velocity.z - k * p.velocity.x).max(0.0); \
         if p.position.z < 0.0 { Vec3::new(0.0, 0.0, push) } else { Vec3::zeros() } }\n";
    for text in [rows, function] {
        let source = forcec::internals::source::span::Source::new("floor.rs", text);
        let known = forcec::Specialization {
            set: vec![("stiffness".to_owned(), vec![Exact::ZERO])],
            ..Default::default()
        };
        let request = forcec::internals::compile::Request { known, ..Default::default() };
        let compiled = forcec::internals::compile::compile(&source, &|_| true, request).expect("it compiles");
        let function = &compiled.functions[0];
        let subject = Subject { source: &function.source, program: &function.program };
        let report = verify::check(&subject, &CheckOptions::default());
        assert!(report.passed, "{}", report.table());
        let of = |family: Family| report.coverage.iter().find(|c| c.family == family).expect("every family");
        assert!(of(Family::Rest).singular > 0 && of(Family::Random).is_covered(), "{}", report.table());
    }
}

/// Where rounding may reach the largest entry, agreement proves nothing: no figure is shown, and the verdict
/// says so.
#[test]
fn what_rounding_hides_is_not_covered() {
    let lets: String = (1..=60).map(|k| format!("let x{k} = x{0} * x{0}.sin();\n", k - 1)).collect();
    let text =
        format!("#[energy]\nfn nested(p: Particle) -> Real {{\nlet x0 = p.position.x;\n{lets}x60\n}}\n");
    let report = checked(&text);
    assert!(report.passed, "{}", report.table());
    assert_eq!(report.not_covered(), [Family::Far]);
    let table = report.table();
    assert!(table.contains("pass*") && !table.contains("inf"), "{table}");
    assert!(report.json().contains("\"not_covered\": [\"far\"]") && !report.json().contains("inf"));
}

/// Every force function of the repository, compiled by the whole pipeline.
fn library() -> Vec<forcec::internals::compile::Stages> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    let mut functions = Vec::new();
    for folder in ["constraints", "tests/unseen"] {
        let entries = std::fs::read_dir(format!("{root}/{folder}")).expect("the folder is there");
        let mut paths: Vec<_> = entries.map(|entry| entry.expect("it can be read").path()).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
        paths.sort();
        for path in paths {
            let text = std::fs::read_to_string(&path).expect("the file can be read");
            let source = forcec::internals::source::span::Source::new(path.display().to_string(), text);
            let compiled = forcec::internals::compile::compile(&source, &|_| true, forcec::Effort::Default);
            let compiled = compiled.unwrap_or_else(|_| panic!("{} compiles", path.display()));
            functions.extend(compiled.functions);
        }
    }
    functions
}

/// The same with few states per family.
#[test]
fn the_library_passes() {
    let check = |function: &forcec::internals::compile::Stages| {
        let subject = Subject { source: &function.source, program: &function.program };
        verify::check(&subject, &CheckOptions { seed: 1, states: 3 })
    };
    let reports: Vec<Report> = library().iter().map(check).collect();
    assert!(reports.len() > 80, "{} kernels", reports.len());
    assert!(reports.iter().all(|report| report.passed), "{}", verify::table(&reports));
}

/// Two independent ways to the same derivatives of the source as written: dual numbers and differences. In
/// 320 bits the results agree to all digits of a double, in doubles up to rounding errors.
#[test]
fn dual_numbers_agree_with_differences() {
    let mut compared = 0;
    for function in library() {
        let subject = Subject { source: &function.source, program: &function.program };
        let probe = Probe::new(&subject);
        if probe.cost() > 1_000_000 {
            continue;
        }
        for family in [Family::Random, Family::Identity, Family::NearSingular] {
            let inputs = probe.draw(family, 3, 1);
            let Some(truth) = probe.truth(&inputs) else { continue };
            let largest = truth.outputs.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let (exact, double) = (probe.text(None, &inputs), probe.text(Some(Precision::F64), &inputs));
            for (k, expected) in truth.outputs.iter().enumerate() {
                let name = || format!("{} {family} {}", function.source.name, probe.name(k).1);
                let slack = 2f64.powi(-52) * expected.abs() + 1e-26 * largest;
                assert!((exact[k] - expected).abs() <= slack, "{}: {} {expected}", name(), exact[k]);
                let slack = if family == Family::NearSingular { 1e-4 } else { 1e-9 };
                assert!((double[k] - expected).abs() <= slack * largest, "{}: {expected}", name());
                compared += 1;
            }
        }
    }
    assert!(compared > 10_000, "{compared} entries");
}

/// The text is evaluated operation by operation, as in rustc: a quotient is one division, a power a chain of
/// products.
#[test]
fn the_text_is_evaluated_as_written() {
    macro_rules! by_hand {
        ($float:ty, $x:expr, $k:expr) => {{
            let (x, k): ([$float; 3], $float) = ($x.map(|x| x as $float), $k as $float);
            let d = x.map(|x| x / k);
            let norm = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
            let n = d.map(|x| x / norm);
            let entry = -k / (d[0] * d[1] - k * 0.3);
            let differences = (d[0] - 1000.1) / 3.0 - 2.0 * n[1] * norm;
            let powers = differences / k + d[2].powi(5) - d[1].powi(-3) * entry;
            f64::from(powers + (0.1 + d[0]) * (0.7 - d[1]) / n[2])
        }};
    }
    let text = "#[energy]\nfn e(p: Particle, k: Real) -> Real {\n\
         let d = p.position / k;\nlet n = d.normalize();\n\
         let m = Mat2::new(d.x, k, 0.3, d.y).inverse();\n\
         let differences = (d.x - 1000.1) / 3.0 - 2.0 * n.y * d.norm();\n\
         differences / k + d.z.powi(5) - d.y.powi(-3) * m[(0, 1)] + (0.1 + d.x) * (0.7 - d.y) / n.z\n}\n";
    let source = forcec::internals::source::span::Source::new("e.rs", text);
    let request = forcec::Request { outputs: vec![Part::Value], ..Default::default() };
    let compiled = forcec::internals::compile::compile(&source, &|_| true, request).expect("it compiles");
    let function = &compiled.functions[0];
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    for state in 0..40 {
        let inputs: Vec<f64> =
            probe.draw(Family::Random, 1, state).iter().map(|x| f64::from(*x as f32)).collect();
        let (x, k) = ([inputs[0], inputs[1], inputs[2]], inputs[6]);
        let by_hand = [by_hand!(f64, x, k), by_hand!(f32, x, k)];
        let text = [Precision::F64, Precision::F32].map(|precision| probe.text(Some(precision), &inputs)[0]);
        assert_eq!(text, by_hand, "state {state}");
    }
}

/// Walls at 1.25 m: k (x − 1.25)/3 on each particle, as a difference or multiplied out.
fn walls(g: &mut Graph, expanded: bool) -> Law {
    let forces = (0..4).map(|body| {
        let (x, k) = (position(g, body), real(g, 0));
        let z = g.component(x, 2);
        let third = Exact::ratio(1, 3);
        let push = if expanded {
            g.sum(Exact::ratio(-5, 12), vec![(third, z)])
        } else {
            let (wall, three) = (g.constant(Exact::ratio(5, 4)), g.constant(Exact::from(3)));
            let gap = g.sub(z, wall);
            g.div(gap, three)
        };
        let (push, zero) = (g.mul(k, push), g.zero());
        Generalised { force: g.pack([zero, zero, push]), torque: None }
    });
    Law::Force(forces.collect())
}

/// The report of a check of a program printed in single precision; `change` modifies the outputs of the
/// program.
fn judged(sample: &Sample, program: &Program, change: fn(&mut [f64])) -> Report {
    let style = Style { strict: true, fma: false, single: false, adds: false };
    let kernel = Kernel::dense("k".into(), vec![], vec![], schedule(program, style, &Meanings::default()));
    let evaluate = |inputs: &dyn Fn(Slot) -> f64| {
        let outputs = kernel.evaluate::<f32>(&|slot| inputs(slot) as f32)?;
        let mut outputs: Vec<f64> = outputs.into_iter().map(f64::from).collect();
        change(&mut outputs);
        Some(outputs)
    };
    let printed = [Printed { precision: Precision::F32, evaluate: &evaluate }];
    let subject = Subject { source: &sample.source(), program };
    verify::check_printed(&subject, &printed, &CheckOptions::default())
}

/// A kernel that loses digits kept by its source fails, although its error is within its own bound; the state
/// is shown.
#[test]
fn a_kernel_worse_than_its_text_fails() {
    let kinds = [BodyKind::PARTICLE; 4];
    let written = sample("walls", &kinds, &[("k", REAL)], |g| walls(g, false));
    let expanded = sample("walls", &kinds, &[("k", REAL)], |g| walls(g, true));
    let report = judged(&written, &expanded.program(), |_| {});
    assert!(report.comparisons.iter().all(|c| c.failures == 0), "{}", report.table());
    assert!(!report.passed, "{}", report.table());
    let worst = report.text[0].worst.as_ref().expect("blocks were compared");
    assert!(
        report.text[0].failures() > 3 && worst.ratio > 4.0 && worst.name.starts_with("force["),
        "{worst:?}"
    );
    let (kernel, text) = (worst.kernel - worst.exact, worst.text - worst.exact);
    assert!(kernel.abs() > 8.0 * text.abs(), "{worst:?}");
    let table = report.table();
    for shown in ["FAIL", "worse than its source as written", "a.position = [", "k = "] {
        assert!(table.contains(shown), "no `{shown}` in\n{table}");
    }
    assert!(report.json().contains("\"precision\": \"f32\""));
}

/// Values that are finite in the text are finite in the kernel.
#[test]
fn a_kernel_that_is_not_finite_where_its_text_is_fails() {
    let written = spring();
    let report = judged(&written, &written.program(), |_| {});
    assert!(report.passed && report.text[0].states > 100, "{}", report.table());
    let report = judged(&written, &written.program(), |outputs| outputs[4] = f64::NAN);
    assert!(!report.passed, "{}", report.table());
    let lost: usize = report.text[0].broken.values().map(|broken| broken.lost).sum();
    assert_eq!(lost, report.text[0].states);
    assert!(report.table().contains("not finite where the source is"), "{}", report.table());
}
