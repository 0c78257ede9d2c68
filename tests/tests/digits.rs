//! Correct values in cases with past loss of digits: near numbers of the text, at zeros, and where powers
//! leave the range of floats.
//!
//! Each row is a function of `tests/cases`, a state, and entries of results that are known by hand; every mode, in both
//! precisions where the numbers fit.

use forcec::internals::compile::{Stages, compile};
use forcec::internals::math::number::Number;
use forcec::internals::model::outputs::Part;
use forcec::internals::source::span::Source;
use forcec::{Mode, Plan};
use forcec_tests::Places;

/// The functions of a case in a mode.
fn case(name: &str, mode: Mode) -> Vec<Stages> {
    let path = format!("{}/cases/{name}.rs", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let plan = Plan { mode, ..Plan::default() };
    compile(&Source::new(path, text), &|_| true, plan).unwrap_or_else(|errors| panic!("{errors}")).functions
}

/// F, and ∂F/∂X row by row.
type Results = (Vec<f64>, Vec<f64>);

/// The results of a kernel in one precision: F, then ∂F/∂X row by row.
fn run<N: Number>(function: &Stages, inputs: &[N], wide: impl Fn(&N) -> f64) -> Results {
    let places = Places::new(&function.program.signature);
    let all = function.kernel.evaluate(&|slot| inputs[places.of(slot)].clone()).expect("all is written");
    let mut at = 0;
    let mut found = (Vec::new(), Vec::new());
    for array in &function.program.arrays {
        let entries = all[at..at + array.entries.len()].iter().map(&wide).collect();
        at += array.entries.len();
        match array.part {
            Part::Force => found.0 = entries,
            Part::Dfdx => found.1 = entries,
            _ => {}
        }
    }
    found
}

/// Both precisions: name, allowed error of a value, and the function that computes F and ∂F/∂X.
fn both(function: &Stages, inputs: &[f64]) -> [(&'static str, f64, Results); 2] {
    let floats: Vec<f32> = inputs.iter().map(|x| *x as f32).collect();
    assert!(
        floats.iter().zip(inputs).all(|(x, y)| f64::from(*x) == *y || (f64::from(*x) / y - 1.0).abs() < 1e-7)
    );
    [("f64", 1e-14, run(function, inputs, |x| *x)), ("f32", 2e-6, run(function, &floats, |x| f64::from(*x)))]
}

fn near(found: f64, right: f64, error: f64) -> bool {
    (found - right).abs() <= error * right.abs() + f64::MIN_POSITIVE
}

/// A particle at a place, at rest.
fn particle(place: [f64; 3]) -> Vec<f64> {
    [place.as_slice(), &[0.0; 3]].concat()
}

fn modes(check: impl Fn(Mode)) {
    for (_, mode, _) in Mode::ALL {
        check(mode);
    }
}

#[test]
fn a_literal_is_not_multiplied_into_a_difference() {
    modes(|mode| {
        for function in case("literal_times_difference", mode) {
            // 2⁻¹² from the number, which is exact in both precisions.
            let gap = 1.0 / 4096.0;
            let (inputs, right) = match function.definition.name.as_str() {
                "bowl" => (particle([1000.0 + gap, 2000.0, 3000.0]), -gap / 9.0),
                // stiffness 9, damping 0
                "wall_row" => ([particle([1000.0 + gap, 0.0, 0.0]), vec![9.0, 0.0]].concat(), -gap),
                "wall_of_parameter" => {
                    ([particle([1000.0 + gap, 0.0, 0.0]), vec![1000.0]].concat(), -gap / 9.0)
                }
                _ => (particle([1000.0 + gap, 0.0, 0.0]), -gap / 9.0),
            };
            for (precision, error, (force, _)) in both(&function, &inputs) {
                let name = &function.definition.name;
                assert!(
                    near(force[0], right, error),
                    "{name} {mode:?} {precision}: {} for {right}",
                    force[0]
                );
            }
        }
    });
}

#[test]
fn powers_of_quotients_stay_in_range() {
    modes(|mode| {
        for exponent in [-30, -10, 0, 10] {
            let s = 2f64.powi(exponent);
            let inputs = [particle([s, 0.0, 0.0]), vec![s]].concat();
            for (precision, error, (force, dfdx)) in both(&case("power_of_quotient", mode)[0], &inputs) {
                assert!(near(force[0], 6.0 / s, error), "{mode:?} {precision} s = {s:e}: {}", force[0]);
                let stiffness = -42.0 / s / s;
                assert!(near(dfdx[0], stiffness, 4.0 * error), "{mode:?} {precision} s = {s:e}: {}", dfdx[0]);
            }
        }
        // Argon, in metres and joules: dE/dr = 24 ε/r ((σ/r)⁶ − 2 (σ/r)¹²).
        let (epsilon, sigma, r): (f64, f64, f64) = (1.65e-21, 3.4e-10, 4.0e-10);
        let six = (sigma / r).powi(6);
        let right = 24.0 * epsilon / r * (six - 2.0 * six * six);
        for function in case("lennard_jones", mode) {
            let mut inputs = [particle([0.0; 3]), particle([r, 0.0, 0.0])].concat();
            inputs.extend(
                (function.definition.name == "pair").then_some([epsilon, sigma]).into_iter().flatten(),
            );
            for (precision, error, (force, dfdx)) in both(&function, &inputs) {
                let name = &function.definition.name;
                assert!(near(force[0], right, 10.0 * error), "{name} {mode:?} {precision}: {}", force[0]);
                assert!(dfdx.iter().all(|x| x.is_finite()), "{name} {mode:?} {precision}: {dfdx:?}");
            }
        }
    });
}

#[test]
fn half_integer_powers_are_finite_at_zero() {
    modes(|mode| {
        for function in case("half_integer_powers", mode) {
            let name = function.definition.name.as_str();
            let place = if name == "hertz" { 1.0 } else { 0.0 };
            for (precision, _, (force, dfdx)) in both(&function, &particle([place, 0.0, 0.0])) {
                assert!(force.iter().all(|x| *x == 0.0), "{name} {mode:?} {precision}: {force:?}");
                // Of a power below 2 the second derivative is infinite at zero.
                if matches!(name, "higher" | "one_sided" | "hertz") {
                    assert!(dfdx.iter().all(|x| *x == 0.0), "{name} {mode:?} {precision}: {dfdx:?}");
                }
            }
            let x = 0.25;
            let power = match name {
                "half_power" => 1.5,
                "higher" => 3.5,
                "one_sided" => 2.5,
                _ => continue,
            };
            let right = -power * f64::powf(x, power - 1.0);
            for (precision, error, (force, _)) in both(&function, &particle([x, 0.0, 0.0])) {
                assert!(near(force[0], right, error), "{name} {mode:?} {precision}: {}", force[0]);
            }
        }
    });
}

#[test]
fn a_squared_length_is_smooth_behind_a_name() {
    modes(|mode| {
        for function in case("norm_squared", mode) {
            let inputs = [particle([1.0, 2.0, 3.0]), particle([1.0, 2.0, 3.0]), vec![5.0]].concat();
            for (precision, _, (force, dfdx)) in both(&function, &inputs) {
                let name = &function.definition.name;
                assert!(force.iter().all(|x| *x == 0.0), "{name} {mode:?} {precision}: {force:?}");
                assert!(dfdx[0] == -5.0 && dfdx[3] == 5.0, "{name} {mode:?} {precision}: {dfdx:?}");
            }
        }
    });
}

/// The sum of an input and a number becomes one node, an offset, in expressions of every form.
#[test]
fn inputs_and_numbers_are_pinned() {
    let texts = [
        "(2.0 * (a.position.y - 7.7) / 3.0).powi(2)",
        "((a.position - Vec3::new(1.5, 7.7, -2.5)) * 0.3).norm_squared()",
        "(k - 7.7) * a.position.x / 7.0",
        "((a.position.y - 7.7) / 3.0 + a.position.x * k).powi(2)",
        "(a.orientation * (u - Vec3::new(0.1, 7.7, 0.3)) * 1.1).y",
    ];
    for text in texts {
        let text = format!("#[energy]\nfn f(a: Rigid, k: Real, u: Vec3) -> Real {{ {text} }}");
        modes(|mode| {
            let plan = Plan { mode, ..Plan::default() };
            let compiled = compile(&Source::new("pinned.rs", &*text), &|_| true, plan);
            let program =
                &compiled.unwrap_or_else(|errors| panic!("{errors}")).functions[0].program.to_string();
            assert!(program.contains("offset"), "{text} {mode:?}\n{program}");
        });
    }
}

/// Of a corner of a cube with edges s: ∂E/∂x₁ = 1/s, and F falls by 1/s² as the edge grows.
#[test]
fn products_stay_in_range_where_positions_meet() {
    modes(|mode| {
        for exponent in [-24, -10, 0, 10] {
            let s = 2f64.powi(exponent);
            let corner = [[0.0; 3], [s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]];
            let mut inputs = corner.map(particle).concat();
            inputs.push(1.0);
            for (precision, error, (force, dfdx)) in both(&case("small_volume", mode)[0], &inputs) {
                let place = format!("{mode:?} {precision} s = {s:e}");
                assert!(near(force[3], -1.0 / s, error), "{place}: {}", force[3]);
                assert!(near(dfdx[3 * 12 + 3], 1.0 / s / s, error), "{place}: {}", dfdx[3 * 12 + 3]);
                assert!(dfdx.iter().all(|x| x.is_finite()), "{place}: {dfdx:?}");
            }
        }
    });
}

/// ∂²/∂y² hypot(y, k) = k²/r³, of which a quotient's derivative, 1/r − y²/r³, keeps nothing where y is large.
#[test]
fn the_curvature_of_a_hypotenuse_does_not_cancel() {
    modes(|mode| {
        let functions = case("methods_of_parameters", mode);
        let function = functions.iter().find(|f| f.definition.name == "g").expect("a case");
        for (y, k) in [(3e6, 0.25), (-40.0, 0.5), (0.0, 2.0)] {
            let inputs = [particle([0.0, y, 0.0]), vec![k]].concat();
            let right = -k * k / f64::hypot(y, k).powi(3);
            for (precision, error, (_, dfdx)) in both(function, &inputs) {
                assert!(near(dfdx[4], right, 2.0 * error), "{mode:?} {precision} {y}: {} {right}", dfdx[4]);
            }
        }
    });
}
