//! Warnings that `forcec lint` gives for a few functions, and warnings that must never appear.

use forcec::internals::compile::compile;
use forcec::internals::lint::{Advice, advise, render};
use forcec::internals::source::span::Source;
use std::path::Path;

fn advice(source: &Source) -> Vec<Advice> {
    let compiled =
        compile(source, &|_| true, forcec::Effort::Quick).unwrap_or_else(|errors| panic!("{errors}"));
    compiled.functions.iter().map(|function| advise(&function.definition)).collect()
}

/// The printed warnings of a force file, by messages and labels.
fn text(source: &Source) -> String {
    let all = advice(source);
    let warnings = |advice: &Advice| {
        advice.warnings.iter().map(|w| format!("warning: {}: {}\n", w.message, w.label)).collect::<String>()
    };
    all.iter().map(|advice| render(advice, source) + &warnings(advice)).collect::<Vec<_>>().join("\n")
}

#[test]
fn two_formulations_of_a_joint() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/formulations/gap.rs");
    insta::assert_snapshot!(text(&Source::new("gap.rs", std::fs::read_to_string(path).unwrap())));
}

/// An energy with an arc cosine, a contact, a rotor that pumps energy, and one that only turns it.
#[test]
fn other_kinds() {
    let source = "
        #[energy]
        #[domain(n = unit)]
        fn tilt(a: Rigid, n: Vec3, k: Real) -> Real { k * (a.orientation * n).z.acos() }

        #[constraint(unilateral)]
        fn floor(p: Particle, height: Real) -> Real { p.position.z - height }

        #[force]
        #[domain(c = 0.1..2.0)]
        fn pump(p: Particle, c: Real) -> Vec3 { c * p.velocity }

        #[force]
        fn magnet(p: Particle, field: Vec3) -> Vec3 { p.velocity.cross(&field) }

        #[energy]
        #[domain(x = -1.0..1.0)]
        fn idle(p: Particle, x: Real) -> Real { p.position.z / x }
    ";
    insta::assert_snapshot!(text(&Source::new("kinds.rs", source)));
}

/// The assumptions of the advice, for every function of the library: constraints dissipate along at most as
/// many directions as they have rows, and ∂F/∂V is symmetric; numbers are not NaN.
#[test]
fn constraints_of_the_library_dissipate() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../constraints");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut constraints = 0;
    for path in paths.filter(|path| path.extension().is_some_and(|ending| ending == "rs")) {
        let source = Source::new("library.rs", std::fs::read_to_string(path).unwrap());
        for advice in advice(&source) {
            for number in [advice.nonlinearity.random, advice.nonlinearity.near].into_iter().flatten() {
                assert!(number.is_finite() && number >= 0.0, "{}: {number}", advice.name);
            }
            if let ("constraint", Some(damping)) = (advice.kind, advice.damping) {
                constraints += 1;
                assert_eq!((damping.active, damping.indefinite), (0, 0), "{}", advice.name);
                assert!(damping.asymmetry < 1e-9, "{}: {}", advice.name, damping.asymmetry);
            }
        }
    }
    assert!(constraints > 20, "the library has constraints: {constraints}");
}

/// The largest step of particles that meet is that of the other formulation, unless it is heavily damped or solved by rows.
#[test]
fn the_norm_is_worse_where_it_is_damped_or_solved_by_rows() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/formulations/gap.rs");
    let all = advice(&Source::new("gap.rs", std::fs::read_to_string(path).unwrap()));
    for pair in all.chunks(2) {
        let [rows, norm] = [&pair[0], &pair[1]].map(|advice| advice.steps.clone().unwrap());
        let step = |step: Option<f64>| step.expect("a stable step");
        assert_eq!(step(rows.full[0]), step(norm.full[0]), "undamped");
        assert!(step(rows.full[2]) > 5.0 * step(norm.full[2]), "heavily damped");
        assert!(step(rows.gauss_newton[0]) > 1.5 * step(norm.gauss_newton[0]), "by rows");
    }
}
