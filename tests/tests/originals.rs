//! The library's functions compiled by rustc with nalgebra, compared with forcec's results for the same text.
//!
//! The values of the functions equal those of the compiler's front end in 320 bits; dual numbers on the body of the
//! function, C, E or F itself, give the kernel's ∂F/∂X. Neither reference shares code with the compiler.

use forcec::internals::compile::{Request, Stages, compile};
use forcec::internals::math::functions::Function;
use forcec::internals::model::outputs::Part;
use forcec::internals::options::plan::{Mode, Plan};
use forcec::internals::scalar::Node;
use forcec::internals::source::span::Source;
use forcec::internals::vector::definition::Law;
use forcec::internals::verify::probe::{Probe, returned};
use forcec::internals::verify::{Family, Subject};
use forcec_tests::{library as compiled, library_text, parallel};
use std::collections::BTreeMap;

/// States a function.
const STATES: usize = 20;

/// A function of the library and its kernel, called with a flat list of inputs.
struct Original {
    name: &'static str,
    value: fn(&mut plain::Flat<'_>) -> Vec<f64>,
    /// ∂F/∂X, row by row.
    kernel: fn(&mut plain::Flat<'_>) -> Vec<f64>,
}

/// A function over dual numbers.
struct Differentiated {
    name: &'static str,
    kind: &'static str,
    unilateral: bool,
    per_row: bool,
    /// Whether each body is rigid; else it is a particle.
    rigid: &'static [bool],
    value: fn(&mut dual::Flat<'_>) -> Vec<dual::Real>,
}

/// Values of one kind of real from a flat list, and back into one.
macro_rules! flat {
    ($real:ty) => {
        pub(super) use forcec_runtime::nalgebra::{Matrix2, Matrix3, Quaternion, SVector, UnitQuaternion};
        use forcec_runtime::{Particle, Rigid, Wrench};

        pub(super) type Real = $real;

        pub(super) struct Flat<'a>(pub(super) std::slice::Iter<'a, Real>);

        impl Flat<'_> {
            pub(super) fn take<T: Take>(&mut self) -> T {
                T::take(self)
            }
        }

        pub(super) trait Take {
            fn take(from: &mut Flat<'_>) -> Self;
        }

        impl Take for Real {
            fn take(from: &mut Flat<'_>) -> Real {
                *from.0.next().expect("as many inputs as the signature has")
            }
        }

        impl<const N: usize> Take for SVector<Real, N> {
            fn take(from: &mut Flat<'_>) -> Self {
                SVector::from(<[Real; N]>::take(from))
            }
        }

        impl Take for Matrix2<Real> {
            fn take(from: &mut Flat<'_>) -> Self {
                Matrix2::from_row_slice(&<[Real; 4]>::take(from))
            }
        }

        impl Take for Matrix3<Real> {
            fn take(from: &mut Flat<'_>) -> Self {
                Matrix3::from_row_slice(&<[Real; 9]>::take(from))
            }
        }

        impl Take for UnitQuaternion<Real> {
            fn take(from: &mut Flat<'_>) -> Self {
                UnitQuaternion::new_unchecked(Quaternion::from_vector(from.take()))
            }
        }

        impl Take for Rigid<Real> {
            fn take(from: &mut Flat<'_>) -> Self {
                let (position, orientation) = (from.take(), from.take());
                Rigid { position, orientation, velocity: from.take(), angular_velocity: from.take() }
            }
        }

        impl Take for Particle<Real> {
            fn take(from: &mut Flat<'_>) -> Self {
                let position = from.take();
                Particle { position, velocity: from.take() }
            }
        }

        impl<T: Take, const N: usize> Take for [T; N] {
            fn take(from: &mut Flat<'_>) -> Self {
                std::array::from_fn(|_| from.take())
            }
        }

        pub(super) trait Give {
            fn give(&self, to: &mut Vec<Real>);
        }

        pub(super) fn flat(value: impl Give) -> Vec<Real> {
            let mut to = Vec::new();
            value.give(&mut to);
            to
        }

        impl Give for Real {
            fn give(&self, to: &mut Vec<Real>) {
                to.push(*self);
            }
        }

        impl<const N: usize> Give for SVector<Real, N> {
            fn give(&self, to: &mut Vec<Real>) {
                to.extend(self.iter().copied());
            }
        }

        impl Give for Wrench<Real> {
            fn give(&self, to: &mut Vec<Real>) {
                self.force.give(to);
                self.torque.give(to);
            }
        }

        impl<A: Give, B: Give> Give for (A, B) {
            fn give(&self, to: &mut Vec<Real>) {
                self.0.give(to);
                self.1.give(to);
            }
        }

        impl<A: Give, B: Give, C: Give> Give for (A, B, C) {
            fn give(&self, to: &mut Vec<Real>) {
                self.0.give(to);
                self.1.give(to);
                self.2.give(to);
            }
        }
    };
}

mod plain {
    flat!(f64);
}

mod dual {
    flat!(num_dual::HyperDual<f64>);

    /// The names that force functions are written with, over dual numbers.
    #[allow(unused_imports, dead_code, reason = "a prelude has what functions may need")]
    pub(super) mod prelude {
        pub(in super::super) use super::{real, times};
        pub(in super::super) use forcec_runtime::functions::{Inverse, Outer};
        pub(in super::super) use forcec_runtime::nalgebra::{ComplexField, RealField};
        pub(in super::super) use std::f64::consts::PI;

        pub(in super::super) type Real = super::Real;
        pub(in super::super) type Vec2 = super::SVector<Real, 2>;
        pub(in super::super) type Vec3 = super::SVector<Real, 3>;
        pub(in super::super) type Vec4 = super::SVector<Real, 4>;
        pub(in super::super) type Mat2 = super::Matrix2<Real>;
        pub(in super::super) type Mat3 = super::Matrix3<Real>;
        pub(in super::super) type Quat = super::UnitQuaternion<Real>;
        pub(in super::super) type Rigid = super::Rigid<Real>;
        pub(in super::super) type Particle = super::Particle<Real>;
        pub(in super::super) type Wrench = super::Wrench<Real>;
    }

    pub(super) fn real(x: f64) -> Real {
        Real::new(x, 0.0, 0.0, 0.0)
    }

    pub(super) fn times<L: Times<R>, R>(left: L, right: R) -> L::Product {
        left.times(right)
    }

    pub(super) trait Times<R> {
        type Product;
        fn times(self, right: R) -> Self::Product;
    }

    macro_rules! times {
        ($([$($size:tt)*] $left:ty, $right:ty => $product:ty: $x:ident, $y:ident, $value:expr;)*) => {$(
            impl<$($size)*> Times<$right> for $left {
                type Product = $product;
                fn times(self, right: $right) -> $product {
                    let ($x, $y) = (self, right);
                    $value
                }
            }
        )*};
    }

    times! {
        [] Real, Real => Real: x, y, x * y;
        [const N: usize] Real, SVector<Real, N> => SVector<Real, N>: x, v, v * x;
        [] Real, Matrix2<Real> => Matrix2<Real>: x, m, m * x;
        [] Real, Matrix3<Real> => Matrix3<Real>: x, m, m * x;
        [const N: usize] SVector<Real, N>, Real => SVector<Real, N>: v, x, v * x;
        [] Matrix2<Real>, Real => Matrix2<Real>: m, x, m * x;
        [] Matrix3<Real>, Real => Matrix3<Real>: m, x, m * x;
        [] Matrix2<Real>, SVector<Real, 2> => SVector<Real, 2>: m, v, m * v;
        [] Matrix3<Real>, SVector<Real, 3> => SVector<Real, 3>: m, v, m * v;
        [] Matrix2<Real>, Matrix2<Real> => Matrix2<Real>: m, n, m * n;
        [] Matrix3<Real>, Matrix3<Real> => Matrix3<Real>: m, n, m * n;
        [] UnitQuaternion<Real>, SVector<Real, 3> => SVector<Real, 3>: q, v, q * v;
        [] UnitQuaternion<Real>, UnitQuaternion<Real> => UnitQuaternion<Real>: q, r, q * r;
    }
}

include!(concat!(env!("OUT_DIR"), "/originals.rs"));

/// States of order one at which all is finite, some at rest and some with identity orientations.
fn states(function: &Stages) -> Vec<Vec<f64>> {
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    let draw = |index: usize| probe.draw(Family::ALL[[0, 0, 0, 1, 2][index % 5]], 11, index);
    (0..STATES).map(draw).collect()
}

/// The largest difference relative to the largest entry.
fn apart(left: &[f64], right: &[f64]) -> f64 {
    assert_eq!(left.len(), right.len());
    let largest = left.iter().chain(right).fold(0.0_f64, |most, x| most.max(x.abs()));
    let difference = left.iter().zip(right).fold(0.0_f64, |most, (x, y)| most.max((x - y).abs()));
    if difference == 0.0 { 0.0 } else { difference / largest }
}

#[test]
fn functions_return_what_the_front_end_says() {
    let originals: BTreeMap<&str, Original> = library().into_iter().map(|o| (o.name, o)).collect();
    let found = parallel(compiled(), |file| {
        let mut worst = Vec::new();
        for function in &file.compiled.functions {
            let name = function.definition.name.as_str();
            let original = originals.get(name).unwrap_or_else(|| panic!("`{name}` is in the crate"));
            let (mut error, mut regular) = (0.0_f64, 0);
            for inputs in states(function) {
                let Some(expected) = returned(&function.source, &inputs) else { continue };
                let value = (original.value)(&mut plain::Flat(inputs.iter()));
                error = error.max(apart(&value, &expected));
                regular += 1;
            }
            assert!(regular > STATES / 4, "{name}: {regular} regular states");
            worst.push((error, name.to_owned()));
        }
        worst
    });
    let mut found: Vec<(f64, String)> = found.into_iter().flatten().collect();
    assert_eq!(found.len(), originals.len(), "every function is compared");
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    println!("{} functions, {STATES} states each; furthest apart: {:?}", found.len(), &found[..3]);
    for (error, name) in found {
        assert!(error < 1e-11, "{name}: rustc and the front end are {error:e} apart");
    }
}

/// A random function: its text, and the function that rustc compiles.
struct Random {
    text: &'static str,
    value: fn(&mut plain::Flat<'_>) -> Vec<f64>,
}

/// The value of a function in mode `strict`: C, E or F.
fn strict(force: bool) -> Request {
    let plan = Plan { mode: Mode::Strict, ..Plan::default() };
    let outputs = vec![if force { Part::Force } else { Part::Value }];
    Request { outputs, ..Request::from(plan) }
}

/// The states at which a strict kernel and rustc differ in a bit: how many, of how many, and one of them.
fn bits_apart(
    function: &Stages,
    value: fn(&mut plain::Flat<'_>) -> Vec<f64>,
) -> (usize, usize, Option<[Vec<f64>; 2]>) {
    let subject = Subject { source: &function.source, program: &function.program };
    let probe = Probe::new(&subject);
    // Angles and rotation vectors have formulas of their own here, which keep their digits where nalgebra's lose them.
    let own = function
        .program
        .graph
        .iter()
        .any(|(_, node)| matches!(node, Node::Call(Function::AngleRatio(_) | Function::CosSqrt(_), _)));
    let (mut apart, mut compared, mut worst) = (0, 0, None);
    for inputs in states(function) {
        let kernel = function.kernel.evaluate(&|slot| probe.input(&inputs, slot)).expect("all is written");
        let original = value(&mut plain::Flat(inputs.iter()));
        if original.iter().all(|x| x.is_finite()) {
            compared += 1;
            let largest = original.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            // Adding zero turns −0 into 0, because the sign of zero is ignored.
            let same = |x: &f64, y: &f64| match own {
                true => (x - y).abs() <= 32.0 * f64::EPSILON * largest,
                false => (x + 0.0).to_bits() == (y + 0.0).to_bits(),
            };
            if kernel.len() != original.len() || !kernel.iter().zip(&original).all(|(x, y)| same(x, y)) {
                apart += 1;
                worst = Some([kernel, original]);
            }
        }
    }
    (apart, compared, worst)
}

#[test]
fn strict_values_have_the_bits_of_the_text() {
    let originals: BTreeMap<&str, Original> = library().into_iter().map(|o| (o.name, o)).collect();
    let mut found = Vec::new();
    for file in compiled() {
        for function in &file.compiled.functions {
            let name = function.definition.name.clone();
            let force = matches!(function.definition.law, Law::Force(_));
            let text = Source::new("library.rs", library_text(&file.stem));
            let strict = compile(&text, &|own| own == name, strict(force)).expect("it compiles");
            found.push((bits_apart(&strict.functions[0], originals[name.as_str()].value), name));
        }
    }
    for random in randoms() {
        let strict = compile(&Source::new("random.rs", random.text), &|_| true, strict(false));
        let strict = strict.unwrap_or_else(|errors| panic!("{errors}"));
        found.push((bits_apart(&strict.functions[0], random.value), random.text.to_owned()));
    }
    println!("{} functions", found.len());
    let compared: usize = found.iter().map(|((_, compared, _), _)| compared).sum();
    assert!(compared > found.len() * STATES / 2, "{compared} states");
    let wrong: Vec<_> = found.iter().filter(|((apart, ..), _)| *apart > 0).collect();
    for ((apart, compared, worst), name) in &wrong {
        println!("{apart} of {compared} states of {name}: {worst:?}");
    }
    assert!(wrong.is_empty(), "{} functions differ", wrong.len());
}

/// ∂F/∂X by dual numbers on the function; `None` where it is not finite.
fn by_duals(function: &Differentiated, inputs: &[f64]) -> Option<Vec<f64>> {
    // Where each coordinate's field starts, which axis it is, whether it turns; and its velocity.
    let mut coordinates = Vec::new();
    let mut at = 0;
    for rigid in function.rigid {
        let velocity = if *rigid { at + 7 } else { at + 3 };
        coordinates.extend((0..3).map(|axis| (at, axis, false, inputs[velocity + axis])));
        if *rigid {
            coordinates.extend((0..3).map(|axis| (at + 3, axis, true, inputs[at + 10 + axis])));
        }
        at += if *rigid { 13 } else { 6 };
    }
    let n = coordinates.len();
    let unit = |axis: usize| std::array::from_fn::<f64, 3, _>(|k| f64::from(u8::from(k == axis)));
    // D_j D_i of all that the function returns: i is moved first, as the inner derivative.
    let moved = |i: usize, j: usize| {
        let mut x: Vec<dual::Real> = inputs.iter().map(|x| dual::real(*x)).collect();
        for (coordinate, step) in
            [(j, dual::Real::new(0.0, 0.0, 1.0, 0.0)), (i, dual::Real::new(0.0, 1.0, 0.0, 0.0))]
        {
            let (start, axis, turns, _) = coordinates[coordinate];
            if !turns {
                x[start + axis] += step;
                continue;
            }
            // q ← (1 + step e/2) q
            let half = unit(axis).map(|e| step * dual::real(0.5 * e));
            let [qx, qy, qz, qw] = std::array::from_fn(|k| x[start + k]);
            x[start] += qw * half[0] + half[1] * qz - half[2] * qy;
            x[start + 1] += qw * half[1] + half[2] * qx - half[0] * qz;
            x[start + 2] += qw * half[2] + half[0] * qy - half[1] * qx;
            x[start + 3] -= half[0] * qx + half[1] * qy + half[2] * qz;
        }
        (function.value)(&mut dual::Flat(x.iter()))
    };
    let mut dfdx = vec![0.0; n * n];
    if function.kind == "force" {
        for j in 0..n {
            for (i, value) in moved(j, j).iter().enumerate() {
                dfdx[i * n + j] = value.eps1;
            }
        }
    } else {
        let second: Vec<Vec<Vec<dual::Real>>> =
            (0..n).map(|i| (0..n).map(|j| moved(i, j)).collect()).collect();
        for row in 0..second[0][0].len() {
            let value = second[0][0][row].re;
            let first = |i: usize| second[i][i][row].eps1;
            let rows = second[0][0].len();
            // Energies are rows with λ = 1 that does not change.
            let (gain, rate_gain) = match (function.kind, function.per_row) {
                ("energy", _) => (0.0, 0.0),
                (_, false) => (inputs[inputs.len() - 2], inputs[inputs.len() - 1]),
                (_, true) => (inputs[inputs.len() - 2 * rows + row], inputs[inputs.len() - rows + row]),
            };
            let rate: f64 = (0..n).map(|k| first(k) * coordinates[k].3).sum();
            let multiplier = if function.kind == "energy" { 1.0 } else { gain * value + rate_gain * rate };
            if function.unilateral && (value >= 0.0 || multiplier >= 0.0) {
                continue;
            }
            for i in 0..n {
                for j in 0..n {
                    let rate: f64 = (0..n).map(|k| second[k][j][row].eps1eps2 * coordinates[k].3).sum();
                    let change = gain * first(j) + rate_gain * rate;
                    dfdx[i * n + j] -= second[i][j][row].eps1eps2 * multiplier + first(i) * change;
                }
            }
        }
    }
    dfdx.iter().all(|x| x.is_finite()).then_some(dfdx)
}

#[test]
fn dual_numbers_on_the_functions_give_the_kernels_derivatives() {
    let originals: BTreeMap<&str, Original> = library().into_iter().map(|o| (o.name, o)).collect();
    let duals: BTreeMap<&str, Differentiated> = duals().into_iter().map(|d| (d.name, d)).collect();
    let found = parallel(compiled(), |file| {
        let mut worst = Vec::new();
        for function in &file.compiled.functions {
            let name = function.definition.name.as_str();
            let Some(differentiated) = duals.get(name) else { continue };
            let (mut error, mut regular) = (0.0_f64, 0);
            for inputs in states(function) {
                let kernel = (originals[name].kernel)(&mut plain::Flat(inputs.iter()));
                let Some(expected) = by_duals(differentiated, &inputs) else { continue };
                error = error.max(apart(&kernel, &expected));
                regular += 1;
            }
            worst.push((error, regular, name.to_owned()));
        }
        worst
    });
    let mut found: Vec<(f64, usize, String)> = found.into_iter().flatten().collect();
    assert_eq!(found.len(), duals.len(), "every function of these files is compared");
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    println!("{} functions; furthest apart: {:?}", found.len(), &found[..5]);
    found.sort_by_key(|(_, regular, _)| *regular);
    println!("fewest regular states of {STATES}: {:?}", &found[..5]);
    for (error, regular, name) in found {
        assert!(regular > STATES / 4, "{name}: {regular} regular states");
        assert!(error < 1e-9, "{name}: dual numbers and the kernel are {error:e} apart");
    }
}
