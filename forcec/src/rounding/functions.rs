//! Values and error propagation of the functions in the function table.
//!
//! In: a function, its arguments and a bound on the error of each argument. Out: the value, computed with
//! IEEE operations only; and a bound on the change of the value, by the mean value theorem: the largest
//! derivative in the interval times the change of the argument; infinite if the interval may leave the
//! domain. Derivatives are rounded too: the enlargement of bounds by 2⁻⁴⁸ covers that where they do not
//! cancel, explicit terms where they do.

use crate::math::functions::Function;
use crate::math::number::Number;
use crate::math::special;
use crate::rounding::running::{Double, Running, times};
use std::f64::consts::PI;

const UNIT: f64 = f64::EPSILON / 2.0;
const NONE: f64 = f64::INFINITY;

/// The value, to about a unit in the last place; `family` computes families.
pub(super) fn value(function: Function, x: &[f64]) -> f64 {
    match function {
        Function::Cbrt => libm::cbrt(x[0]),
        Function::Powf => libm::pow(x[0], x[1]),
        Function::Exp => libm::exp(x[0]),
        Function::Ln => libm::log(x[0]),
        Function::Ln1p => libm::log1p(x[0]),
        Function::ExpM1 => libm::expm1(x[0]),
        Function::Sin => libm::sin(x[0]),
        Function::Cos => libm::cos(x[0]),
        Function::Tan => libm::tan(x[0]),
        Function::Asin => libm::asin(x[0]),
        Function::Acos => libm::acos(x[0]),
        Function::Atan => libm::atan(x[0]),
        Function::Atan2 => libm::atan2(x[0], x[1]),
        Function::Sinh => libm::sinh(x[0]),
        Function::Cosh => libm::cosh(x[0]),
        Function::Tanh => libm::tanh(x[0]),
        Function::Hypot => libm::hypot(x[0], x[1]),
        Function::HypotSlope => x[0] / libm::hypot(x[0], x[1]),
        Function::Asinh(_)
        | Function::Acosh(_)
        | Function::Atanh(_)
        | Function::Sinc(_)
        | Function::Erf
        | Function::Erfc
        | Function::ErfSlope
        | Function::Logistic
        | Function::LogisticSlope
        | Function::Softplus
        | Function::LnCosh => {
            let x = Running::<Double>::known(x[0]);
            special::evaluate(function, &[x]).map_or(f64::NAN, |value| value.value())
        }
        // Exact or correctly rounded functions; and families, which [`family`] computes.
        Function::Pi
        | Function::Abs
        | Function::Sqrt
        | Function::Min
        | Function::Max
        | Function::Signum
        | Function::CosSqrt(_)
        | Function::AngleRatio(_) => (function.row().value)(x),
    }
}

/// The value of a function whose code is printed with the kernel, computed by the same code.
pub(super) fn family<N: Number>(function: Function, arguments: impl FnOnce() -> Vec<N>) -> Option<N> {
    match function {
        Function::CosSqrt(n) => Some(special::cos_sqrt(u32::from(n), arguments().swap_remove(0))),
        // The derivatives of `sinc` have zeros.
        Function::Sinc(_) => special::evaluate(function, &arguments()),
        Function::AngleRatio(n) => {
            let [m, w] = <[N; 2]>::try_from(arguments()).ok()?;
            Some(special::angle_ratio(u32::from(n), m, w))
        }
        _ => None,
    }
}

/// A bound on the change of the value if each argument changes by at most its error.
pub(super) fn passed(function: Function, x: &[f64], errors: &[f64]) -> f64 {
    if errors.iter().all(|error| *error == 0.0) {
        return 0.0;
    }
    if errors.iter().any(|error| !error.is_finite()) {
        return NONE;
    }
    let at = |function| value(function, x).abs();
    let (a, e) = (x[0], errors[0]);
    // The end of the interval that is nearest to zero.
    let least = a.abs() - e;
    let positive = |x: f64, bound: &dyn Fn() -> f64| if x > 0.0 { bound() } else { NONE };
    // eᵗ − 1 ≤ t + t² for t ≤ 1, and cosh t ≤ 1 + t².
    let growth = |t: f64| if t <= 1.0 { t + t * t } else { NONE };
    match function {
        // `Running::root` propagates errors through a root, with their sign.
        Function::Pi | Function::Sqrt => 0.0,
        Function::Abs => e,
        Function::Signum => positive(least, &|| 0.0),
        Function::Min | Function::Max => e.max(errors[1]),
        // ∛ is steepest at the end nearest to zero, where it is at least |∛a| (1 − t).
        Function::Cbrt => positive(least, &|| at(Function::Cbrt) * e / (3.0 * least)),
        Function::Powf => positive(a - e, &|| {
            let relative = (x[1].abs() + errors[1]) * e / (a - e) + at(Function::Ln) * errors[1];
            times(at(Function::Powf), growth(relative))
        }),
        Function::Exp => times(at(Function::Exp), growth(e)),
        Function::ExpM1 => times(at(Function::Exp), growth(e)),
        Function::Ln => positive(a - e, &|| e / (a - e)),
        Function::Ln1p => {
            let near = 1.0 + a - e - 4.0 * UNIT * (1.0 + a.abs());
            positive(near, &|| e / near)
        }
        // |f″| ≤ 1 and |f′| ≤ 1
        Function::Sin => e.min(at(Function::Cos) * e + e * e),
        Function::Cos => e.min(at(Function::Sin) * e + e * e),
        // tan(a ± e) − tan a = ± tan e (1 + tan² a)/(1 ∓ tan e tan a), and tan e ≤ e + e² for e ≤ ½.
        Function::Tan => {
            let (r, t) = (at(Function::Tan), e + e * e);
            positive((0.5 - e).min(1.0 - 2.0 * t * r), &|| t * (1.0 + r * r) / (1.0 - t * r))
        }
        Function::Asin | Function::Acos => {
            let far = (a.abs() + e) * (1.0 + 4.0 * UNIT);
            positive(1.0 - far, &|| e / ((1.0 - far) * (1.0 + far)).sqrt())
        }
        Function::Atan => e / (1.0 + least.max(0.0) * least.max(0.0)),
        // The gradient has length 1/distance from the origin; the cut is half of the second axis, x < 0.
        Function::Atan2 => {
            let cut = x[1] - errors[1] <= 0.0 && least <= 0.0;
            let (distance, way) = (at(Function::Hypot), libm::hypot(e, errors[1]));
            positive(if cut { 0.0 } else { distance * (1.0 - 8.0 * UNIT) - way }, &|| way / (distance - way))
        }
        // The derivative at a, plus half the largest second derivative on the way: sinh, cosh ≤ cosh a · eᵉ.
        Function::Sinh => at(Function::Cosh) * (1.0 + growth(e)) * e,
        Function::Cosh => at(Function::Sinh) * e + at(Function::Cosh) * (1.0 + growth(e)) * e * e,
        Function::Tanh => {
            let r = at(Function::Tanh);
            e.min(((1.0 - r) * (1.0 + r) + 8.0 * UNIT) * e + e * e)
        }
        // The first two derivatives of asinh are at most 1/(1 + x²)^(½, 1), the third twice that to the power
        // 3/2.
        Function::Asinh(n) => {
            let slope = value(Function::Asinh(1), &[least.max(0.0)]);
            (0..n).fold(e * f64::from(n.max(1)), |bound, _| bound * slope) * slope
        }
        // Derivatives of acosh decrease in size.
        Function::Acosh(n) => positive(a - e - 1.0, &|| e * value(Function::Acosh(n + 1), &[a - e]).abs()),
        // Derivatives of atanh increase towards ±1.
        Function::Atanh(n) => {
            let far = (a.abs() + e) * (1.0 + 4.0 * UNIT);
            positive(1.0 - far, &|| e * value(Function::Atanh(n + 1), &[far]))
        }
        // f⁽ᵏ⁾ = ∫₀¹ tᵏ cos(x t + k π/2) dt, at most 1/(k + 1).
        Function::Sinc(n) => {
            let (next, most) = (value(Function::Sinc(n + 1), x).abs(), f64::from(n + 2));
            e * (next + 8.0 * UNIT + e).min(1.0 / most)
        }
        Function::Erf | Function::Erfc => e * value(Function::ErfSlope, &[least.max(0.0)]),
        Function::ErfSlope => times(2.0 * e * (a.abs() + e), value(Function::ErfSlope, &[least.max(0.0)])),
        // The second derivative is smaller than the first.
        Function::Logistic | Function::LogisticSlope => e * value(Function::LogisticSlope, &[least.max(0.0)]),
        Function::Softplus => e * value(Function::Logistic, &[a + e]),
        Function::LnCosh => e * libm::tanh(a.abs() + e),
        Function::Hypot => libm::hypot(e, errors[1]),
        // The gradient is at most as long as 1/distance from the origin.
        Function::HypotSlope => {
            let (distance, way) = (at(Function::Hypot), libm::hypot(e, errors[1]));
            positive(distance * (1.0 - 8.0 * UNIT) - way, &|| way / (distance - way))
        }
        // |dᵏ/dsᵏ cos √s| is largest at 0, k!/(2k)!; below zero it grows no faster than eᵗ.
        Function::CosSqrt(n) => {
            let largest = (1..=u32::from(n) + 1).fold(1.0, |f, k| f / f64::from(4 * k - 2));
            let below = (e - a).max(0.0);
            largest * e * (1.0 + growth(below))
        }
        Function::AngleRatio(n) => angle_ratio(u32::from(n), [a, x[1]], [e, errors[1]]),
    }
}

/// The nth derivative by m of A = atan2(√m, w)/√m. Its derivative by w is (−1)ⁿ⁺¹ n!/(m + w²)ⁿ⁺¹. Derivatives
/// by m, for w > 0: A = ∫₀¹ w/(w² + m t²) dt, so |A⁽ᵏ⁾| falls with m and is at most w⁺/w⁻ times its value at
/// the least w. For w ≤ 0: A = π/√m − A(m, |w|), so |A⁽ᵏ⁾| is at most the kth derivative of π/√m in size.
fn angle_ratio(n: u32, [m, w]: [f64; 2], [of_m, of_w]: [f64; 2]) -> f64 {
    let m = m - of_m;
    let near = (w.abs() - of_w).max(0.0);
    let norm = m + near * near;
    let factorial = (1..=n).fold(1.0, |product, k| product * f64::from(k));
    let by_w = factorial / (0..=n).fold(1.0, |power, _| power * norm);
    let by_m = if w - of_w > 0.0 && m >= 0.0 {
        let (low, high) = (w - of_w, w + of_w);
        let [at_m, at_w] = [m, low].map(Running::<Double>::known);
        let steepest = special::angle_ratio(n + 1, at_m, at_w);
        (steepest.value().abs() + steepest.error()) * (high / low)
    } else if m > 0.0 {
        (0..=n).fold(PI / m.sqrt(), |steepest, k| steepest * (f64::from(k) + 0.5) / m)
    } else {
        NONE
    };
    let passed = times(by_m, of_m) + times(by_w, of_w);
    if norm > 0.0 && passed.is_finite() { passed } else { NONE }
}
