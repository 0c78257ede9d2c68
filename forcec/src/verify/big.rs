//! 320-bit floating-point numbers, in which `forcec check` evaluates the source.
//!
//! In: doubles and exact numbers. Out: all operations and all functions of the table, accurate to about 310
//! bits, with NaN and infinities as in IEEE arithmetic. The families `cos_sqrt` and `angle_ratio` have their
//! own formulas here, independent of those in kernels.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use crate::math::number::{Arithmetic, Comparison, Number};
use astro_float_num::{BigFloat, Consts, INF_NEG, INF_POS, NAN, Radix, RoundingMode, Sign};
use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::rc::Rc;

/// The number of bits in a mantissa.
pub(crate) const BITS: usize = 320;
const ROUND: RoundingMode = RoundingMode::ToEven;

thread_local! {
    static CONSTANTS: RefCell<Consts> =
        RefCell::new(Consts::new().expect("memory for the digits of a few constants"));
}

fn constants<T>(f: impl FnOnce(&mut Consts) -> T) -> T {
    CONSTANTS.with(|constants| f(&mut constants.borrow_mut()))
}

/// A 320-bit number; cloning is cheap.
#[derive(Clone, Debug)]
pub(crate) struct Big(Rc<BigFloat>);

impl From<BigFloat> for Big {
    fn from(x: BigFloat) -> Big {
        Big(Rc::new(x))
    }
}

impl Big {
    pub(crate) fn from_f64(x: f64) -> Big {
        Big::from(match x {
            _ if x.is_nan() => NAN,
            f64::INFINITY => INF_POS,
            f64::NEG_INFINITY => INF_NEG,
            _ => BigFloat::from_f64(x, BITS),
        })
    }

    pub(crate) fn zero() -> Big {
        Big::from(BigFloat::new(BITS))
    }

    pub(crate) fn integer(n: i32) -> Big {
        Big::from(BigFloat::from_i32(n, BITS))
    }

    /// The nearest double, up to a unit in the last place.
    pub(crate) fn to_f64(&self) -> f64 {
        if self.0.is_nan() {
            return f64::NAN;
        }
        let Some((words, _, sign, exponent, _)) = self.0.as_raw_parts() else {
            return if self.0.is_inf_neg() { f64::NEG_INFINITY } else { f64::INFINITY };
        };
        let size = words.iter().rev().take(2).rev().fold(0.0, |sum, &w| (sum + w as f64) * 2f64.powi(-64));
        let exponent = exponent.clamp(-1400, 1400);
        let scaled = size * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2);
        if sign == Sign::Neg { -scaled } else { scaled }
    }

    /// x 2ⁿ
    pub(crate) fn scaled(mut self, n: i32) -> Big {
        if let (Some(exponent), false) = (self.0.exponent(), self.0.is_zero()) {
            Rc::make_mut(&mut self.0).set_exponent(exponent.saturating_add(n));
        }
        self
    }

    /// e such that |x| < 2ᵉ; `None` for zero, infinities and NaN.
    pub(crate) fn exponent(&self) -> Option<i32> {
        if self.0.is_zero() { None } else { self.0.exponent() }
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    pub(crate) fn is_finite(&self) -> bool {
        !self.0.is_nan() && !self.0.is_inf()
    }

    /// The sign, as the order of x and zero.
    pub(crate) fn sign(&self) -> Ordering {
        match (self.is_zero(), self.is_negative()) {
            (true, _) => Ordering::Equal,
            (_, true) => Ordering::Less,
            _ => Ordering::Greater,
        }
    }

    pub(crate) fn is_negative(&self) -> bool {
        self.0.is_negative() && !self.0.is_zero()
    }

    pub(crate) fn abs(&self) -> Big {
        if self.is_negative() { -self.clone() } else { self.clone() }
    }

    /// √x from the reciprocal root of a double; each Newton step y ← y (3 − m y²)/2 doubles the correct
    /// digits.
    pub(crate) fn sqrt(&self) -> Big {
        let Some(exponent) = self.exponent().filter(|_| !self.is_negative()) else {
            return Big::from(self.0.sqrt(BITS, ROUND));
        };
        let half = exponent.div_euclid(2);
        let m = self.clone().scaled(-2 * half);
        let mut y = Big::from_f64(1.0 / m.to_f64().sqrt());
        for _ in 0..3 {
            let rest = Big::integer(3) - m.clone() * y.clone() * y.clone();
            y = y * rest.scaled(-1);
        }
        let root = m.clone() * y.clone();
        let rest = (m - root.clone() * root.clone()) * y;
        (root + rest.scaled(-1)).scaled(half)
    }

    fn order(&self, other: &Big) -> Option<Ordering> {
        self.0.cmp(&other.0).map(|order| order.cmp(&0))
    }

    fn pi() -> Big {
        Big::from(constants(|c| c.pi(BITS, ROUND)))
    }

    /// selfʸ. A small integer power is a product: it may be exact in more than 320 bits, and then the general
    /// routine computes further digits for minutes to decide the rounding.
    fn power(&self, y: &Big) -> Big {
        let n = y.to_f64();
        if n.abs() > 256.0 || n.fract() != 0.0 || !(y.clone() - Big::from_f64(n)).is_zero() {
            return Big::from(constants(|c| self.0.pow(&y.0, BITS, ROUND, c)));
        }
        let mut product = Big::integer(1);
        for _ in 0..n.abs() as u32 {
            product = product * self.clone();
        }
        if n < 0.0 { Big::integer(1) / product } else { product }
    }

    fn atan(&self) -> Big {
        Big::from(constants(|c| self.0.atan(BITS, ROUND, c)))
    }

    /// The angle of the point (x, self).
    fn atan2(&self, x: &Big) -> Big {
        let half_turn = || if self.0.is_negative() { -Big::pi() } else { Big::pi() };
        if self.0.is_nan() || x.0.is_nan() {
            return Big::from(NAN);
        }
        if x.is_zero() {
            return if self.is_zero() { Big::zero() } else { half_turn().scaled(-1) };
        }
        let angle = (self.clone() / x.clone()).atan();
        if x.is_negative() { angle + half_turn() } else { angle }
    }

    /// Σ terms until they are negligible; `next` computes a term from its predecessor and its index.
    fn series(first: Big, next: impl Fn(&Big, i32) -> Big, weight: impl Fn(&Big, i32) -> Big) -> Big {
        let mut term = first;
        let mut sum = weight(&term, 0);
        for j in 1..4000 {
            term = next(&term, j);
            let add = weight(&term, j);
            let negligible = match (add.exponent(), sum.exponent()) {
                (Some(a), Some(s)) => a < s - BITS as i32 - 8 && j > 8,
                (None, _) => true,
                _ => false,
            };
            if negligible {
                break;
            }
            sum = sum + add;
        }
        sum
    }

    /// eˣ; zero far below every double. Near zero, the general routine would compute further digits to decide
    /// the rounding, as in `power`.
    fn exp(&self) -> Big {
        match self.exponent() {
            Some(e) if e <= -8 => Big::integer(1) + self.exp_m1(),
            Some(e) if e > 24 && self.is_negative() => Big::zero(),
            _ => Big::from(constants(|c| self.0.exp(BITS, ROUND, c))),
        }
    }

    /// eˣ − 1, near zero by Σ xᵏ/k!, because the difference would cancel.
    fn exp_m1(&self) -> Big {
        if self.exponent().is_none_or(|e| e > -8) {
            return self.exp() - Big::integer(1);
        }
        let next = |term: &Big, k: i32| term.clone() * self.clone() / Big::integer(k + 1);
        Big::series(self.clone(), next, |term, _| term.clone())
    }

    /// ln(1 + x), near zero by 2 atanh z = 2 Σ z²ᵏ⁺¹/(2k + 1) with z = x/(2 + x).
    fn ln_1p(&self) -> Big {
        if self.exponent().is_none_or(|e| e > -8) {
            return Big::from(constants(|c| (Big::integer(1) + self.clone()).0.ln(BITS, ROUND, c)));
        }
        let z = self.clone() / (Big::integer(2) + self.clone());
        let square = z.clone() * z.clone();
        let next = |term: &Big, _| term.clone() * square.clone();
        Big::series(z.scaled(1), next, |term, k| term.clone() / Big::integer(2 * k + 1))
    }

    /// Derivatives of asinh and acosh from the first one, 1/√q with q = x² + c: −x/√q³ and (2x² − c)/√q⁵.
    fn inverse_hyperbolic(n: u8, x: &Big, q: Big, c: Big) -> Big {
        let root = q.sqrt();
        match n {
            1 => Big::integer(1) / root,
            2 => -x.clone() / (q * root),
            _ => ((x.clone() * x.clone()).scaled(1) - c) / (q.clone() * q * root),
        }
    }

    /// dⁿ/dxⁿ sin(x)/x for n ≤ 3: derivatives of −2 C′(x²), C = cos √s; far from zero from x f = sin x.
    fn sinc(n: u8, x: &Big) -> Big {
        if x.exponent().is_none_or(|e| e < 6) {
            let s = x.clone() * x.clone();
            let c = |k| Big::cos_sqrt(k, &s);
            return match n {
                0 => -c(1).scaled(1),
                1 => -(c(2) * x.clone()).scaled(2),
                2 => -(c(2) + (s.clone() * c(3)).scaled(1)).scaled(2),
                _ => -(x.clone() * (Big::integer(3) * c(3) + (s.clone() * c(4)).scaled(1))).scaled(3),
            };
        }
        let sine = Big::from(constants(|c| x.0.sin(BITS, ROUND, c)));
        let cosine = Big::from(constants(|c| x.0.cos(BITS, ROUND, c)));
        let waves = [sine.clone(), cosine.clone(), -sine, -cosine];
        (1..=n).fold(waves[0].clone() / x.clone(), |value, k| {
            (waves[usize::from(k)].clone() - Big::integer(i32::from(k)) * value) / x.clone()
        })
    }

    /// 2/√π e^(−x²)
    fn erf_slope(&self) -> Big {
        (-(self.clone() * self.clone())).exp().scaled(1) / Big::pi().sqrt()
    }

    /// 2/√π e^(−x²) Σ 2ᵏ x²ᵏ⁺¹/(2k + 1)!!, all terms of one sign; beyond 8, 1 − erfc x.
    fn erf(&self) -> Big {
        if self.exponent().is_some_and(|e| e > 3) {
            let value = Big::integer(1) - self.abs().erfc();
            return if self.is_negative() { -value } else { value };
        }
        let square = self.clone() * self.clone();
        let next = |term: &Big, k: i32| (term.clone() * square.clone()).scaled(1) / Big::integer(2 * k + 1);
        self.erf_slope() * Big::series(self.clone(), next, |term, _| term.clone())
    }

    /// Beyond 8 the continued fraction e^(−x²)/√π / (x + ½/(x + 1/(x + (3/2)/(x + …)))); below, 1 − erf x,
    /// which is accurate to 220 bits at 8.
    fn erfc(&self) -> Big {
        if self.is_negative() || self.exponent().is_none_or(|e| e <= 3) {
            return Big::integer(1) - self.erf();
        }
        let fraction =
            (1..=200).rev().fold(self.clone(), |below, k| self.clone() + Big::integer(k).scaled(-1) / below);
        self.erf_slope().scaled(-1) / fraction
    }

    /// dⁿ/dsⁿ cos √s, an entire function: Σ (−1)^(j+n) (j+n)!/(j! (2j+2n)!) sʲ. Beyond |s| = 4000 the derivatives
    /// follow from 4s y″ + 2y′ + y = 0.
    fn cos_sqrt(n: u8, s: &Big) -> Big {
        let n = i32::from(n);
        if s.exponent().is_none_or(|e| e <= 12) && s.is_finite() {
            // The ratio of consecutive coefficients of order k of cos √s is −1/((2k − 1)(2k)).
            let ratio = |term: Big, k: i32| -(term / Big::integer((2 * k - 1) * 2 * k));
            let first = (1..=n).fold(Big::integer(1), |term, k| ratio(term * Big::integer(k), k));
            let next = |term: &Big, j: i32| {
                let term = ratio(term.clone() * s.clone() * Big::integer(j + n), j + n);
                term / Big::integer(j)
            };
            return Big::series(first, next, |term, _| term.clone());
        }
        let t = s.sqrt();
        let mut low = Big::from(constants(|c| t.0.cos(BITS, ROUND, c)));
        let sine = Big::from(constants(|c| t.0.sin(BITS, ROUND, c)));
        let mut high = -(sine / t).scaled(-1);
        for k in 0..n {
            let next = -(low + Big::integer(4 * k + 2) * high.clone()) / s.clone().scaled(2);
            (low, high) = (high, next);
        }
        low
    }

    /// ∂ⁿ/∂mⁿ atan2(√m, w)/√m. For small x = m/w² and w > 0 the series w^(−2n−1) Σ (−1)^(j+n) (j+n)!/(j!
    /// (2j+2n+1)) xʲ; else derivatives of A′ = (½ w/(m + w²) − ½ A)/m, which lose at most 10 n bits.
    fn angle_ratio(n: u8, m: &Big, w: &Big) -> Big {
        let n = i32::from(n);
        let square = w.clone() * w.clone();
        let x = m.clone() / square.clone();
        let small = x.is_finite() && x.exponent().is_none_or(|e| e < -10);
        if small && Big::zero().order(w) == Some(Ordering::Less) {
            let first =
                (1..=n).fold(Big::integer(1) / w.clone(), |f, k| -(f * Big::integer(k)) / square.clone());
            let next =
                |term: &Big, j: i32| -(term.clone() * x.clone() * Big::integer(j + n)) / Big::integer(j);
            return Big::series(first, next, |term, j| term.clone() / Big::integer(2 * j + 2 * n + 1));
        }
        let t = m.sqrt();
        let mut value = t.atan2(w) / t;
        let norm = m.clone() + square;
        let mut term = (w.clone() / norm.clone()).scaled(-1);
        for k in 0..n {
            value = (term.clone() - Big::integer(2 * k + 1) * value.scaled(-1)) / m.clone();
            term = -(term * Big::integer(k + 1)) / norm.clone();
        }
        value
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl $trait for Big {
            type Output = Big;
            fn $name(self, other: Big) -> Big {
                Big::from(self.0.$name(&other.0, BITS, ROUND))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Big {
    type Output = Big;
    fn neg(mut self) -> Big {
        Rc::make_mut(&mut self.0).inv_sign();
        self
    }
}

impl Arithmetic for Big {
    fn exact(value: &Exact) -> Big {
        let near = value.to_f64();
        if Exact::from_f64(near).as_ref() == Some(value) {
            return Big::from_f64(near);
        }
        let (numerator, denominator) = value.parts();
        let parse = |digits: &str| {
            let wide = BITS.max(digits.len() * 4);
            Big::from(constants(|c| BigFloat::parse(digits, Radix::Dec, wide, ROUND, c)))
        };
        parse(&numerator) / parse(&denominator)
    }

    fn call(function: Function, x: &[Big]) -> Big {
        use Function::{
            Abs, Acos, Acosh, AngleRatio, Asin, Asinh, Atan, Atan2, Atanh, Cbrt, Cos, CosSqrt, Cosh, Erf,
            ErfSlope, Erfc, Exp, ExpM1, Hypot, HypotSlope, Ln, Ln1p, LnCosh, Logistic, LogisticSlope, Max,
            Min, Pi, Powf, Signum, Sin, Sinc, Sinh, Softplus, Sqrt, Tan, Tanh,
        };
        let one = || Big::integer(1);
        let with = |f: fn(&BigFloat, usize, RoundingMode, &mut Consts) -> BigFloat, x: &Big| {
            Big::from(constants(|c| f(&x.0, BITS, ROUND, c)))
        };
        match function {
            Pi => Big::pi(),
            Abs => x[0].abs(),
            Sqrt => x[0].sqrt(),
            Cbrt => Big::from(x[0].0.cbrt(BITS, ROUND)),
            Powf => x[0].power(&x[1]),
            Exp => x[0].exp(),
            Ln => with(BigFloat::ln, &x[0]),
            Ln1p => x[0].ln_1p(),
            ExpM1 => x[0].exp_m1(),
            Sin => with(BigFloat::sin, &x[0]),
            Cos => with(BigFloat::cos, &x[0]),
            Tan => with(BigFloat::tan, &x[0]),
            Asin => with(BigFloat::asin, &x[0]),
            Acos => with(BigFloat::acos, &x[0]),
            Atan => x[0].atan(),
            Atan2 => x[0].atan2(&x[1]),
            Sinh => with(BigFloat::sinh, &x[0]),
            Cosh => with(BigFloat::cosh, &x[0]),
            Tanh => with(BigFloat::tanh, &x[0]),
            Asinh(0) => with(BigFloat::asinh, &x[0]),
            Acosh(0) => with(BigFloat::acosh, &x[0]),
            Atanh(0) => with(BigFloat::atanh, &x[0]),
            Asinh(n) => {
                let x = x[0].clone();
                let square = one() + x.clone() * x.clone();
                Big::inverse_hyperbolic(n, &x, square, one())
            }
            Acosh(n) => {
                let x = x[0].clone();
                let square = (x.clone() - one()) * (x.clone() + one());
                Big::inverse_hyperbolic(n, &x, square, -one())
            }
            Atanh(n) => {
                let x = x[0].clone();
                let d = (one() - x.clone()) * (one() + x.clone());
                match n {
                    1 => one() / d,
                    2 => x.scaled(1) / (d.clone() * d),
                    _ => (Big::integer(2) + Big::integer(6) * x.clone() * x) / (d.clone() * d.clone() * d),
                }
            }
            Sinc(n) => Big::sinc(n, &x[0]),
            Erf => x[0].erf(),
            Erfc => x[0].erfc(),
            ErfSlope => x[0].erf_slope(),
            Logistic | LogisticSlope => {
                let small = (-x[0].abs()).exp();
                let sum = one() + small.clone();
                match function {
                    LogisticSlope => small / (sum.clone() * sum),
                    _ if x[0].is_negative() => small / sum,
                    _ => one() / sum,
                }
            }
            Softplus => {
                let rest = (-x[0].abs()).exp().ln_1p();
                if x[0].is_negative() { rest } else { x[0].clone() + rest }
            }
            LnCosh if x[0].exponent().is_none_or(|e| e < 6) => {
                let sine = with(BigFloat::sinh, &x[0]);
                (sine.clone() * sine).ln_1p().scaled(-1)
            }
            LnCosh => {
                let rest = (-x[0].abs().scaled(1)).exp().ln_1p();
                x[0].abs() - with(BigFloat::ln, &Big::integer(2)) + rest
            }
            Hypot => (x[0].clone() * x[0].clone() + x[1].clone() * x[1].clone()).sqrt(),
            HypotSlope => x[0].clone() / Big::call(Hypot, x),
            Min if x[0].0.is_nan() || x[1].order(&x[0]) == Some(Ordering::Less) => x[1].clone(),
            Max if x[0].0.is_nan() || x[0].order(&x[1]) == Some(Ordering::Less) => x[1].clone(),
            Min | Max => x[0].clone(),
            Signum if x[0].0.is_nan() => x[0].clone(),
            Signum => Big::integer(if x[0].is_negative() { -1 } else { 1 }),
            CosSqrt(n) => Big::cos_sqrt(n, &x[0]),
            AngleRatio(n) => Big::angle_ratio(n, &x[0], &x[1]),
        }
    }
}

impl Number for Big {
    fn holds(comparison: Comparison, x: &Big, y: &Big) -> bool {
        let order = x.order(y);
        match comparison {
            Comparison::Less => order == Some(Ordering::Less),
            Comparison::LessEqual => matches!(order, Some(Ordering::Less | Ordering::Equal)),
            Comparison::Equal => order == Some(Ordering::Equal),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::functions::FunctionDomain;

    fn close(x: &Big, y: &Big, bits: i32) {
        let error = (x.clone() - y.clone()).exponent();
        let size = y.exponent().unwrap_or(0);
        assert!(error.is_none_or(|e| e < size - bits), "{} and {}", x.to_f64(), y.to_f64());
    }

    #[test]
    fn doubles_go_through_unchanged() {
        for x in [0.0, 1.0, -0.1, 1e300, -3e-300, f64::MAX, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(Big::from_f64(x).to_f64(), x);
        }
        assert!(Big::from_f64(f64::NAN).to_f64().is_nan());
        let third = Big::exact(&Exact::ratio(1, 3));
        close(&(third * Big::integer(3)), &Big::integer(1), 310);
    }

    #[test]
    fn every_function_agrees_with_its_row() {
        let points = [0.02, 0.3, 0.77, 0.99];
        for function in Function::ALL {
            for (x, y) in points.iter().flat_map(|x| points.map(|y| (*x, y))) {
                // Arguments beyond the lower bound of the domain.
                let from = match function.row().domain {
                    FunctionDomain::AtLeast(bound) | FunctionDomain::Above(bound) => bound.max(0.0),
                    _ => 0.0,
                };
                let arguments = &[from + x, y][..function.row().arity];
                let wide: Vec<Big> = arguments.iter().map(|x| Big::from_f64(*x)).collect();
                let (value, expected) =
                    (Big::call(function, &wide).to_f64(), (function.row().value)(arguments));
                let error = (value - expected).abs();
                assert!(error <= 1e-14 * expected.abs(), "{function:?}({arguments:?}): {value}, {expected}");
            }
        }
    }

    #[test]
    fn families_are_each_others_derivatives() {
        let step = |x: &Big| x.clone() + Big::integer(1).scaled(-100);
        for s in [-0.5, 0.0, 1e-9, 0.3, 7.0, 50.0, 3000.0, 5000.0] {
            for n in 0..4 {
                let s = Big::from_f64(s);
                let difference = Big::cos_sqrt(n, &step(&s)) - Big::cos_sqrt(n, &s);
                close(&difference.scaled(100), &Big::cos_sqrt(n + 1, &s), 70);
            }
        }
        for (m, w) in [(0.0, 1.0), (1e-9, 1.0), (1e-4, 0.3), (0.3, 0.8), (0.9, -0.1), (0.2, -0.9), (0.5, 0.0)]
        {
            for n in 0..3 {
                let (m, w) = (Big::from_f64(m), Big::from_f64(w));
                let difference = Big::angle_ratio(n, &step(&m), &w) - Big::angle_ratio(n, &m, &w);
                close(&difference.scaled(100), &Big::angle_ratio(n + 1, &m, &w), 70);
            }
        }
    }

    #[test]
    fn roots_square_to_their_argument() {
        for x in [2.0, 0.3, 1e-300, 7e299, 4.0, 1e-5] {
            let x = Big::from_f64(x);
            close(&(x.sqrt() * x.sqrt()), &x, 316);
            close(&x.sqrt(), &Big::from(x.0.sqrt(BITS, ROUND)), 316);
        }
        assert!(Big::integer(-1).sqrt().to_f64().is_nan());
        assert!(Big::zero().sqrt().is_zero());
    }

    #[test]
    fn angles_lie_in_their_quadrant() {
        for (y, x) in
            [(1.0, 2.0), (1.0, -2.0), (-1.0, -2.0), (-1.0, 2.0), (1.0, 0.0), (-1.0, 0.0), (0.0, -1.0)]
        {
            let angle = Big::from_f64(y).atan2(&Big::from_f64(x)).to_f64();
            assert!((angle - f64::atan2(y, x)).abs() < 1e-15, "{y} {x}");
        }
    }
}
