//! The states of a check reach every arm of every branch, for numbers of any scale in the function.

use forcec::internals::compile::{Request, Stages, compile};
use forcec::internals::math::exact::Exact;
use forcec::internals::source::span::Source;
use forcec::internals::verify::{self, CheckOptions, Report, Subject};
use forcec::{Mode, Specialization};

fn stages(text: &str, request: Request) -> Stages {
    let compiled = compile(&Source::new("force.rs", text), &|_| true, request);
    let compiled = compiled.unwrap_or_else(|errors| panic!("{errors}\n{text}"));
    compiled.functions.into_iter().next().expect("a force function")
}

fn report(function: &Stages, states: usize) -> Report {
    let subject = Subject { source: &function.source, program: &function.program };
    verify::check(&subject, &CheckOptions { states, ..CheckOptions::default() })
}

/// The report of a function that passes with every arm active at some state.
fn covered(text: &str) -> Report {
    let report = report(&stages(text, Request::default()), 20);
    assert!(report.passed && report.covers_branches(), "{text}\n{}", report.table());
    assert!(report.coverage.iter().any(|family| family.active > 0), "{text}\n{}", report.table());
    report
}

/// Functions whose numbers are far from order one: their switches are found, and both sides checked.
#[test]
fn switches_are_found_at_any_scale() {
    for text in [
        "#[constraint(unilateral)]\nfn wall(p: Particle) -> Real { p.position.x + 100.0 }\n",
        "#[constraint(unilateral)]\nfn skin(p: Particle) -> Real { 1e-6 - (p.position.z - 1000.0).abs() }\n",
        "#[energy]\nfn cavity(a: Rigid, k: Real) -> Real {\n if a.position.norm_squared() > 10000.0 \
         { 0.5 * k * a.position.x * a.position.x } else { 0.0 }\n}\n",
        "#[energy]\nfn lim(a: Rigid, k: Real, u: Vec3) -> Real {\n let over = (a.orientation * u).x - 1000.0;\n \
         let far = a.position.y - 50.0;\n if far > 0.0 { k * far * far } else { if over > 0.0 { over } else { 0.0 } }\n}\n",
        "#[energy]\n#[domain(normal = unit, radius = 1e-5..1e-4, k = 1e5..1e6)]\n\
         fn micro(p: Particle, origin: Vec3, normal: Vec3, radius: Real, k: Real) -> Real {\n \
         let depth = radius - (normal.dot(&(p.position - origin))).abs();\n \
         if depth > 0.0 { 0.4 * k * depth * depth * depth.sqrt() } else { 0.0 }\n}\n",
        "#[energy]\n#[domain(r0 = 1e-10..2e-10, k = 100.0..500.0)]\n\
         fn bond(p: Particle, q: Particle, r0: Real, k: Real) -> Real {\n \
         let d = (q.position - p.position).norm();\n \
         if d < 3.0 * r0 { 0.5 * k * (d - r0) * (d - r0) } else { 2.0 * k * r0 * r0 }\n}\n",
        "#[energy]\n#[domain(r0 = 1e8..2e8)]\nfn orbit(p: Particle, q: Particle, r0: Real) -> Real {\n \
         let d = (q.position - p.position).norm();\n if d < r0 { (d - r0) * (d - r0) } else { 0.0 }\n}\n",
        "#[energy]\n#[domain(dhat2 = 1e-8..1e-6)]\nfn barrier(p: Particle, q: Particle, dhat2: Real) -> Real {\n \
         let d2 = (q.position - p.position).norm_squared();\n \
         if d2 < dhat2 { let t = d2 - dhat2; -t * t * (d2 / dhat2).ln() } else { 0.0 }\n}\n",
        "#[energy]\n#[domain(length = 1e-10)]\nfn stated(p: Particle, q: Particle, k: Real) -> Real {\n \
         let d = q.position - p.position;\n if d.x > 1e-11 { k * d.x * d.x } else { 0.0 }\n}\n",
        "#[energy]\n#[domain(p.position = -1e-9..1e-9)]\nfn ranged(p: Particle, k: Real) -> Real {\n \
         if p.position.z < 2e-10 { k * (p.position.z - 2e-10) * (p.position.z - 2e-10) } else { 0.0 }\n}\n",
    ] {
        covered(text);
    }
}

/// Three conditions within each other, each on another input, all far away.
#[test]
fn arms_within_arms_are_found() {
    let text = "#[energy]\nfn nest(p: Particle, q: Particle, k: Real) -> Real {\n \
         if p.position.x > 30.0 && p.position.y < -20.0 {\n \
         if q.position.z > 1e3 || q.position.x < -70.0 { k * p.position.z.max(40.0) } else { q.position.y.abs() }\n \
         } else { 0.0 }\n}\n";
    let report = covered(text);
    assert_eq!(report.branches.len(), 4, "{}", report.table());
}

/// An arm that no state can be on is not covered, and its line is named.
#[test]
fn a_contradiction_is_not_covered() {
    let text = "#[energy]\nfn never(p: Particle) -> Real {\n let x = p.position.x * p.position.x;\n \
         if x + 1.0 < 0.0 { p.position.y } else { x }\n}\n";
    let report = report(&stages(text, Request::default()), 5);
    assert!(report.passed && !report.covers_branches());
    assert_eq!(report.branches[0].states[0], 0);
    assert!(report.branches[0].span.is_some());
    let table = report.table();
    assert!(table.contains("`then` of if is not covered"), "{table}");
    assert!(report.json().contains("\"covered\": false"), "{}", report.json());
}

/// The author says so, with a reason.
#[test]
fn an_arm_out_of_reach_is_allowed() {
    let text = "#[energy]\n#[allow(uncovered, reason = \"a square is positive\")]\nfn never(p: Particle) -> Real {\n \
         let x = p.position.x * p.position.x;\n if x + 1.0 < 0.0 { p.position.y } else { x }\n}\n";
    let report = report(&stages(text, Request::default()), 5);
    assert!(report.covers_branches());
    assert!(report.table().contains("which is allowed"), "{}", report.table());
}

/// Bodies are drawn where they are stated to be.
#[test]
fn large_elements_have_regular_states() {
    let bodies: Vec<String> = (0..8).map(|n| format!("p{n}: Particle")).collect();
    let positions: Vec<String> = (0..8).map(|n| format!("p{n}.position")).collect();
    let text = format!(
        "#[energy]\n#[domain(grad = -3.0..3.0, weight = 1e-3..1e-1, mu = 1e2..1e4)]\nfn hex({}, grad: [[Vec3; 8]; 8], \
         weight: [Real; 8], mu: Real) -> Real {{\n let x = [{}];\n let mut e = 0.0;\n for q in 0..8 {{\n \
         let mut f = Mat3::zeros();\n for n in 0..8 {{ f += x[n].outer(&grad[q][n]); }}\n let l = f.determinant().ln();\n \
         e += weight[q] * mu * (0.5 * (f.norm_squared() - 3.0) - l + 0.5 * l * l);\n }}\n e\n}}\n",
        bodies.join(", "),
        positions.join(", ")
    );
    let report = report(&stages(&text, Request::default()), 2);
    assert!(report.passed && report.states() >= 5, "{}", report.table());
}

/// With damping known at compile time, nothing is checked at damping 0.
#[test]
fn constant_damping_passes() {
    let spring = "#[constraint]\nfn spring(p: Particle, q: Particle, l: Real) -> Real \
         { (q.position - p.position).norm() - l }\n";
    let ball = "#[constraint]\nfn ball(a: Rigid, b: Rigid, u: Vec3, v: Vec3) -> Vec3 \
         { b.position + b.orientation * v - a.position - a.orientation * u }\n";
    let values = [Exact::ONE, Exact::ratio(1, 2), Exact::ratio(2, 1), Exact::ratio(-1, 1), Exact::ZERO];
    for (text, value) in [spring, ball].iter().flat_map(|text| values.iter().map(move |value| (text, value)))
    {
        let set = vec![("damping".to_owned(), vec![value.clone()])];
        let request = Request { known: Specialization { set, ..Default::default() }, ..Default::default() };
        let report = report(&stages(text, request), 3);
        assert!(report.passed, "{}", report.table());
    }
}

/// Differences of a kernel in doubled precision are differences of what it computes.
#[test]
fn kernels_in_doubled_precision_are_checked_as_they_are() {
    let text = "#[constraint]\nfn bend(a: Particle, b: Particle, c: Particle, d: Particle, w: Vec4) -> Vec3 \
         { a.position * w.x + b.position * w.y + c.position * w.z + d.position * w.w }\n";
    let report = report(
        &stages(
            text,
            Request {
                plan: forcec::Plan { mode: Mode::Accurate, ..Default::default() },
                ..Default::default()
            },
        ),
        5,
    );
    assert!(report.passed && report.differences.disagree == 0, "{}", report.table());
}

/// Every arm of the library's functions, and of those that no pass was tuned on, is reached, or said to be out of reach.
#[test]
fn every_arm_of_the_library_is_covered() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
    for folder in ["constraints", "tests/unseen"] {
        let entries = std::fs::read_dir(format!("{root}/{folder}")).expect("the folder is there");
        let mut paths: Vec<_> = entries.map(|entry| entry.expect("it can be read").path()).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
        paths.sort();
        for path in paths {
            let text = std::fs::read_to_string(&path).expect("the file can be read");
            let source = Source::new(path.display().to_string(), text);
            let compiled = compile(&source, &|_| true, Request::default());
            let compiled = compiled.unwrap_or_else(|_| panic!("{} compiles", path.display()));
            for function in compiled.functions {
                let report = report(&function, 4);
                assert!(report.passed && report.covers_branches(), "{}", report.table());
            }
        }
    }
}
