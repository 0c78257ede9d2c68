//! Bounds of rounding errors for every kernel of the library: the error of an entry never exceeds its bound.

use forcec::internals::compile::{Stages, compile};
use forcec::internals::kernel::Precision;
use forcec::internals::options::plan::{Effort, Mode, Plan};
use forcec::internals::rounding::observed::compare;
use forcec::internals::rounding::{Analysis, rounding, upward};
use forcec::internals::source::span::Source;
use forcec::internals::verify::Family;
use std::path::Path;

/// States of each family at which every entry is compared.
const STATES: usize = 6;

/// Every force function of the library, compiled.
fn library(plan: Plan) -> Vec<Stages> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../constraints");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "rs"));
    paths.sort();
    let mut functions = Vec::new();
    for path in paths {
        let source = Source::new(path.display().to_string(), std::fs::read_to_string(&path).unwrap());
        functions.extend(compile(&source, &|_| true, plan).unwrap_or_else(|e| panic!("{e}")).functions);
    }
    assert!(functions.len() > 50, "the library is where it is expected");
    functions
}

/// At every state with a value in 320 bits the error of each entry is within its bound.
fn holds(plan: Plan) {
    let (mut compared, mut tight, mut half) = (0, 0, 0);
    for function in library(plan) {
        for precision in [Precision::F64, Precision::F32] {
            let analysis = Analysis::new(&function.kernel, precision);
            for (family, index) in
                Family::ALL.into_iter().flat_map(|family| (0..STATES).map(move |index| (family, index)))
            {
                let Some((values, entries)) = analysis.regular(family, index) else { continue };
                let Some(errors) = analysis.observed(&values, &entries) else { continue };
                for (k, (entry, error)) in entries.iter().zip(&errors).enumerate() {
                    assert!(
                        error.error <= entry.error,
                        "{} in {precision}, {family} {index}, entry {k}: {:e} is off by {:e}, at most {:e} by its bound",
                        function.kernel.name,
                        entry.value,
                        error.error,
                        entry.error
                    );
                    compared += 1;
                    tight += usize::from(error.error > entry.error / 100.0);
                    half += usize::from(error.error > entry.error / 2.0);
                }
            }
        }
    }
    assert!(compared > 300_000, "{compared} entries");
    // Among entries with rounding errors, few have bounds a hundred times as large as the error.
    assert!(tight * 4 > compared, "{tight} of {compared} entries come near their bound");
    // Bounds half as large would fail at thousands of entries.
    assert!(half > 1000, "{half} of {compared} entries are off by more than half of their bound");
}

#[test]
fn no_error_exceeds_its_bound_balanced() {
    holds(Plan::default());
}

#[test]
fn no_error_exceeds_its_bound_strict() {
    holds(Plan { mode: Mode::Strict, effort: Effort::Quick, ..Plan::default() });
}

#[test]
fn no_error_exceeds_its_bound_fast_and_fused() {
    holds(Plan { mode: Mode::Fast, effort: Effort::Quick, fma: true, ..Plan::default() });
}

#[test]
fn no_error_exceeds_its_bound_accurate() {
    holds(Plan { mode: Mode::Accurate, effort: Effort::Quick, ..Plan::default() });
}

/// The analysis computes the same values as the kernel: bit by bit without library functions, otherwise
/// within the bounds.
#[test]
fn values_are_those_of_the_statements() {
    for function in library(Effort::Quick.into()) {
        let kernel = &function.kernel;
        let calls = kernel.schedule.operations().call > 0;
        for precision in [Precision::F64, Precision::F32] {
            let analysis = Analysis::new(kernel, precision);
            for index in 0..STATES {
                let Some((values, entries)) = analysis.regular(Family::Random, index) else { continue };
                let plain: Vec<f64> = match precision {
                    Precision::F64 => {
                        let found = kernel.schedule.evaluate(&|slot| analysis.input(&values, slot)).unwrap();
                        found.iter().copied().collect()
                    }
                    Precision::F32 => {
                        let input = |slot| analysis.input(&values, slot) as f32;
                        let found = kernel.schedule.evaluate(&input).unwrap();
                        found.iter().map(|x| f64::from(*x)).collect()
                    }
                };
                for (entry, plain) in entries.iter().zip(plain) {
                    let apart = (entry.value - plain).abs();
                    let same = if calls { apart <= 2.0 * entry.error } else { apart == 0.0 };
                    assert!(same, "{} in {precision}: {:e}, {plain:e}", kernel.name, entry.value);
                }
            }
        }
    }
}

/// At states of order one every result of the library has a bound, and the head of its kernel says so.
#[test]
fn the_library_has_bounds() {
    for function in library(Plan::default()) {
        let kernel = &function.kernel;
        let stated = rounding(kernel, Precision::F64);
        assert!(!stated.lines().is_empty(), "{}", kernel.name);
        for bound in stated.bounds {
            assert_eq!(bound.unbounded, 0, "{}, {}", kernel.name, bound.part);
            assert!(bound.relative < 1e-12, "{}, {}: {:e}", kernel.name, bound.part, bound.relative);
            let compared = compare(kernel, Precision::F64, &[Family::Random]);
            let own = compared.iter().find(|own| own.part == bound.part).unwrap();
            assert_eq!(
                own.bound, bound.relative,
                "{}: the head comment and the check have the same bound",
                kernel.name
            );
            assert!(own.observed <= own.bound && own.quotient <= 1.0, "{own:?}");
        }
    }
}

/// The report says that an output has no bound if a divisor may be zero, if a branch depends on rounding, or if
/// a difference cancels completely.
#[test]
fn missing_bounds_are_reported() {
    let bound = |body: &str| {
        let text = format!("#[energy]\npub fn e(p: Particle, s: Real) -> Real {{ {body} }}\n");
        let compiled =
            compile(&Source::new("e.rs", text), &|_| true, Effort::Quick).unwrap_or_else(|e| panic!("{e}"));
        rounding(&compiled.functions[0].kernel, Precision::F64).lines().join(" ")
    };
    let finite = bound("s * p.position.norm_squared()");
    assert!(finite.contains("force ≤ ") && !finite.contains("no bound"), "{finite}");
    // (x + 1)² − x² − 2x − 1 is zero except for rounding.
    let square = "let x = p.position.x; let y = (x + 1.0) * (x + 1.0) - x * x - 2.0 * x - 1.0;";
    let cancels = bound(&format!("{square} p.position.y / y"));
    assert!(!cancels.contains("of the largest entry") || cancels.contains("no bound"), "{cancels}");
    let choice = bound(&format!(
        "{square} if y.sin() < 1e-30 {{ p.position.norm_squared() }} else {{ 2.0 * p.position.norm_squared() }}"
    ));
    assert!(choice.contains("no bound"), "{choice}");
}

#[test]
fn two_digits_are_rounded_up() {
    for (x, text) in [
        (0.0, "0"),
        (1.0, "1.0e0"),
        (1.01e-15, "1.1e-15"),
        (1.04e-15, "1.1e-15"),
        (1.06e-15, "1.1e-15"),
        (9.91e-8, "1.0e-7"),
        (9.95e-8, "1.0e-7"),
        (3.0e300, "3.0e300"),
    ] {
        assert_eq!(upward(x), text);
    }
}
