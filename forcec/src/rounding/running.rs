//! Floating-point numbers with a rigorous bound on their error.
//!
//! In: inputs, which are exact, and operations. Out: the rounded result of each operation, and a bound on its
//! distance to the exact value, the result of the same operations without rounding. The bound contains the
//! propagated errors of the operands, products of errors included, and the rounding of the operation, half a
//! unit in the last place of the result. Bounds are rounded up: each is a sum of at most ten products of
//! nonnegative numbers, enlarged by the factor 1 + 2⁻⁴⁸. Exact operations, such as subtraction of nearby
//! numbers or multiplication by a power of two, add nothing. Operations follow IEEE 754, subnormal numbers
//! included; a result that overflows has no bound.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Comparison, Number};
use crate::rounding::functions;
use std::cell::Cell;
use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A floating-point format; its numbers are stored as doubles.
pub(super) trait Format: Copy {
    /// Whether rounding errors are computed with their signs, not only bounded.
    const SIGNED: bool = false;
    /// Half the distance from 1 to the next number.
    const UNIT: f64;
    /// The smallest positive normal number.
    const NORMAL: f64;
    /// The smallest positive number.
    const LEAST: f64;

    /// Rounds to the format. For a sum, product, quotient or root that was rounded to a double first, the
    /// result is correctly rounded: a double has more than twice the digits (Figueroa 1995).
    fn round(x: f64) -> f64;

    /// x y + z, rounded once.
    fn fused(x: f64, y: f64, z: f64) -> f64;

    /// The nearest number of the format to an exact number.
    fn nearest(value: &Exact) -> f64;
}

/// `f64`
#[derive(Clone, Copy)]
pub(super) struct Double;

impl Format for Double {
    const UNIT: f64 = f64::EPSILON / 2.0;
    const NORMAL: f64 = f64::MIN_POSITIVE;
    const LEAST: f64 = LEAST;

    fn round(x: f64) -> f64 {
        x
    }

    fn fused(x: f64, y: f64, z: f64) -> f64 {
        x.mul_add(y, z)
    }

    fn nearest(value: &Exact) -> f64 {
        value.to_f64()
    }
}

/// `f32`
#[derive(Clone, Copy)]
pub(super) struct Single;

impl Format for Single {
    const UNIT: f64 = f32::EPSILON as f64 / 2.0;
    const NORMAL: f64 = f32::MIN_POSITIVE as f64;
    const LEAST: f64 = f32::MIN_POSITIVE as f64 * f32::EPSILON as f64;

    fn round(x: f64) -> f64 {
        f64::from(x as f32)
    }

    fn fused(x: f64, y: f64, z: f64) -> f64 {
        f64::from((x as f32).mul_add(y as f32, z as f32))
    }

    fn nearest(value: &Exact) -> f64 {
        f64::from(value.to_f32())
    }
}

/// The same format, with signed rounding errors.
#[derive(Clone, Copy)]
pub(super) struct Signed<F>(PhantomData<F>);

impl<F: Format> Format for Signed<F> {
    const SIGNED: bool = true;
    const UNIT: f64 = F::UNIT;
    const NORMAL: f64 = F::NORMAL;
    const LEAST: f64 = F::LEAST;

    fn round(x: f64) -> f64 {
        F::round(x)
    }

    fn fused(x: f64, y: f64, z: f64) -> f64 {
        F::fused(x, y, z)
    }

    fn nearest(value: &Exact) -> f64 {
        F::nearest(value)
    }
}

/// The smallest positive double.
const LEAST: f64 = f64::MIN_POSITIVE * f64::EPSILON;
/// The factor that covers the rounding of a bound itself.
const UP: f64 = 1.0 + 1.0 / (1u64 << 48) as f64;
/// Between this and its inverse, a double can represent the rounding error of a product or quotient.
const SMALL: f64 = 1e-270;

/// Rounds a bound up.
pub(super) fn up(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x * UP }
}

/// The product of two bounds; positive if both factors are.
pub(super) fn times(x: f64, y: f64) -> f64 {
    if x == 0.0 || y == 0.0 { 0.0 } else { x * y + LEAST }
}

/// A computed number: the exact value is value + drift, up to ± rest. The drift is zero without signed
/// errors.
#[derive(Clone, Copy)]
pub(super) struct Running<'s, F> {
    value: f64,
    drift: f64,
    rest: f64,
    /// The flag that is set if rounding may change a comparison.
    undecided: Option<&'s Cell<bool>>,
    format: PhantomData<F>,
}

/// The exact minus the computed value: a signed estimate, `drift`, and a bound on the remainder, `rest`.
#[derive(Clone, Copy, Default)]
struct Missing {
    drift: f64,
    rest: f64,
}

impl Missing {
    /// A bound without an estimate.
    fn at_most(rest: f64) -> Missing {
        Missing { drift: 0.0, rest }
    }

    /// Adds terms to the drift, and their rounding errors to the rest.
    fn plus(self, terms: &[f64], rest: f64) -> Missing {
        let drift = terms.iter().fold(self.drift, |sum, term| sum + term);
        let size = terms.iter().fold(self.drift.abs(), |sum, term| sum + term.abs());
        let rounded = if size == 0.0 { 0.0 } else { size * (terms.len() + 4) as f64 * f64::EPSILON + LEAST };
        Missing { drift, rest: self.rest + rest + rounded }
    }
}

impl<'s, F: Format> Running<'s, F> {
    /// An argument; a comparison that depends on it and that rounding may change sets `undecided`.
    pub(super) fn input(value: f64, undecided: &'s Cell<bool>) -> Running<'s, F> {
        Running { undecided: Some(undecided), ..Running::known(value) }
    }

    /// An exact number.
    pub(super) fn known(value: f64) -> Running<'s, F> {
        Running { value, drift: 0.0, rest: 0.0, undecided: None, format: PhantomData }
    }

    pub(super) fn value(self) -> f64 {
        self.value
    }

    /// A bound on the distance to the exact value.
    pub(super) fn error(self) -> f64 {
        if self.drift == 0.0 { self.rest } else { up(self.drift.abs() + self.rest) }
    }

    /// A result of these operands, with its error.
    fn of(operands: &[Running<'s, F>], value: f64, missing: Missing) -> Running<'s, F> {
        let rest = up(missing.rest);
        let bounded = value.is_finite() && missing.drift.is_finite() && !rest.is_nan();
        Running {
            value,
            drift: if bounded { missing.drift } else { 0.0 },
            rest: if bounded { rest } else { f64::INFINITY },
            undecided: operands.iter().find_map(|x| x.undecided),
            format: PhantomData,
        }
    }

    /// The largest rounding error if the rounded result is `value`.
    fn half_unit(value: f64) -> f64 {
        /// The exponent bits: a double without its fraction is a power of two.
        const EXPONENT: u64 = 0x7ff << 52;
        let size = value.abs();
        if size >= F::NORMAL { f64::from_bits(size.to_bits() & EXPONENT) * F::UNIT } else { F::LEAST }
    }

    /// The error of rounding `wide` + `lost` to `value`.
    fn rounded(value: f64, wide: f64, lost: Option<f64>) -> Missing {
        match lost {
            Some(0.0) if value == wide => Missing::default(),
            Some(lost) if F::SIGNED => Missing::default().plus(&[wide - value, lost], 0.0),
            _ => Missing::at_most(Self::half_unit(value)),
        }
    }

    fn sum(self, other: Self, sign: f64) -> Self {
        let (x, y) = (self.value, sign * other.value);
        let (wide, lost) = exact_sum(x, y);
        let value = F::round(wide);
        let missing = Self::rounded(value, wide, Some(lost));
        let passed = [self.drift, sign * other.drift];
        Self::of(&[self, other], value, missing.plus(&passed, self.rest + other.rest))
    }

    /// Adds the propagated errors of a product's factors.
    fn through(self, other: Self, missing: Missing) -> Missing {
        let (x, y) = (self.value.abs(), other.value.abs());
        let rest = times(x, other.rest) + times(y, self.rest) + times(self.error(), other.error());
        missing.plus(&[self.value * other.drift, other.value * self.drift], rest)
    }
}

/// The sum of two doubles and its rounding error (Knuth).
fn exact_sum(x: f64, y: f64) -> (f64, f64) {
    let sum = x + y;
    let second = sum - x;
    (sum, (x - (sum - second)) + (y - second))
}

/// The product of two doubles and its rounding error, unless a double may be unable to represent the error.
fn exact_product(x: f64, y: f64) -> (f64, Option<f64>) {
    let product = x * y;
    let zero = x == 0.0 || y == 0.0;
    (product, (zero || product.abs() > SMALL).then(|| x.mul_add(y, -product)))
}

impl<F: Format> Add for Running<'_, F> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.sum(other, 1.0)
    }
}

impl<F: Format> Sub for Running<'_, F> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.sum(other, -1.0)
    }
}

impl<F: Format> Mul for Running<'_, F> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (wide, lost) = exact_product(self.value, other.value);
        let value = F::round(wide);
        let missing = Self::rounded(value, wide, lost);
        Self::of(&[self, other], value, self.through(other, missing))
    }
}

impl<F: Format> Div for Running<'_, F> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let (x, y) = (self.value, other.value);
        let wide = x / y;
        let value = F::round(wide);
        let zero = x == 0.0 && y != 0.0;
        let ordinary = [x, y, wide].iter().all(|x| (SMALL..1.0 / SMALL).contains(&x.abs()));
        let lost = (zero || ordinary).then(|| -wide.mul_add(y, -x) / y);
        let missing = Self::rounded(value, wide, lost);
        // X/Y − x/y = n/Y with n = (X − x) − (x/y) (Y − y), and n/Y − n/y = n (y − Y)/(y Y).
        let least = y.abs() - other.error();
        let n = self.drift - value * other.drift;
        let of_n = self.rest + times(value.abs(), other.rest) + times(Self::half_unit(value), other.error());
        let of_n = Missing::at_most(of_n).plus(&[self.drift, value * other.drift], 0.0).rest;
        let missing = match self.error() + other.error() {
            0.0 => missing,
            _ if least > 0.0 => {
                let curved = times(n.abs() / least, other.error() / y.abs());
                missing.plus(&[n / y], of_n / least + curved + LEAST)
            }
            _ => Missing::at_most(f64::INFINITY),
        };
        Self::of(&[self, other], value, missing)
    }
}

impl<F: Format> Neg for Running<'_, F> {
    type Output = Self;
    fn neg(self) -> Self {
        Running { value: -self.value, drift: -self.drift, ..self }
    }
}

impl<F: Format> Running<'_, F> {
    fn root(self) -> Self {
        let x = self.value;
        let wide = x.sqrt();
        let value = F::round(wide);
        // √x = w + r/(2 w) − …, with r = x − w².
        let ordinary = x == 0.0 || (SMALL..1.0 / SMALL).contains(&x);
        let first = if x == 0.0 { 0.0 } else { -wide.mul_add(wide, -x) / (2.0 * wide) };
        let missing = Self::rounded(value, wide, ordinary.then_some(first));
        let second = if F::SIGNED && x > 0.0 { first * first / wide } else { 0.0 };
        // √X − √x = (X − x)/s with s = √X + √x.
        let (e, least) = (self.error(), x - self.error());
        let missing = match e {
            0.0 => missing.plus(&[], second),
            _ if least > 0.0 => {
                let s = wide + least.sqrt();
                let curved = times(self.drift.abs() / s, e / (s * wide));
                missing.plus(&[self.drift / (2.0 * wide)], self.rest / s + curved + second)
            }
            _ => Missing::at_most(f64::INFINITY),
        };
        Self::of(&[self], value, missing)
    }
}

impl<F: Format> Arithmetic for Running<'_, F> {
    fn exact(number: &Exact) -> Self {
        let value = F::nearest(number);
        let exact = Exact::from_f64(value).as_ref() == Some(number);
        Self::of(&[], value, Self::rounded(value, value, exact.then_some(0.0)))
    }

    fn fused(x: Self, y: Self, z: Self) -> Self {
        let value = F::fused(x.value, y.value, z.value);
        let (product, lost) = exact_product(x.value, y.value);
        let missing = match lost {
            Some(lost) if F::SIGNED => {
                let (sum, second) = exact_sum(product, z.value);
                Missing::default().plus(&[sum - value, second, lost], 0.0)
            }
            _ => Missing::at_most(Self::half_unit(value)),
        };
        Self::of(&[x, y, z], value, x.through(y, missing).plus(&[z.drift], z.rest))
    }

    fn call(function: Function, x: &[Self]) -> Self {
        if function == Function::Sqrt {
            return x[0].root();
        }
        let values: Vec<f64> = x.iter().map(|x| x.value).collect();
        let errors: Vec<f64> = x.iter().map(|x| x.error()).collect();
        let passed = functions::passed(function, &values, &errors);
        if let Some(own) = functions::family(function, || {
            // Runs the code that is printed with the kernel, with exact arguments; its running error covers
            // either side of a comparison that rounding may change.
            x.iter().map(|x| Self::known(x.value)).collect()
        }) {
            // The truncation error of its series is far below a unit.
            let rest = passed + own.error() + Self::half_unit(own.value);
            return Self::of(x, own.value, Missing::at_most(rest));
        }
        let value = F::round(functions::value(function, &values));
        // `units` refers to the exact result; twice as many units of the returned value are more.
        let units = function.units();
        let rounded = if units == 0.0 { 0.0 } else { times(2.0 * units * F::UNIT, value.abs()) + F::LEAST };
        Self::of(x, value, Missing::at_most(passed + rounded))
    }
}

impl<F: Format> Number for Running<'_, F> {
    fn holds(comparison: Comparison, x: &Self, y: &Self) -> bool {
        let (apart, error) = ((x.value - y.value).abs(), x.error() + y.error());
        let decided = error == 0.0 || apart > up(error) * UP;
        if let (false, Some(undecided)) = (decided, x.undecided.or(y.undecided)) {
            undecided.set(true);
        }
        f64::holds(comparison, &x.value, &y.value)
    }
}
