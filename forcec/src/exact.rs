//! Exact rational numbers: every literal and coefficient, from the source text to emission.
//!
//! In: decimal literals and small integers. Out: arithmetic without rounding, and the nearest `f64` or `f32` once,
//! when a kernel is printed. Invariant: reduced to lowest terms, so equal numbers are equal values.

use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};

/// A rational number in lowest terms.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Exact(RBig);

impl Exact {
    /// 0
    pub const ZERO: Exact = Exact(RBig::ZERO);
    /// 1
    pub const ONE: Exact = Exact(RBig::ONE);

    /// `numerator / denominator`. Panics if the denominator is zero.
    pub fn ratio(numerator: i64, denominator: u64) -> Exact {
        Exact(RBig::from_parts(IBig::from(numerator), UBig::from(denominator)))
    }

    /// The value of a decimal literal such as `12`, `0.5`, `1e-3` or `1_000.0`, without suffix.
    /// `None` if it is no decimal number, or beyond the range of `f64` or a thousand digits.
    pub fn parse(literal: &str) -> Option<Exact> {
        let text: String = literal.chars().filter(|c| *c != '_').collect();
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (text.as_str(), 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = format!("{whole}{fraction}");
        let plain = digits.bytes().all(|b| b.is_ascii_digit()) && !digits.is_empty();
        if !plain || digits.len() > 1000 || exponent.abs() > 2000 {
            return None;
        }
        let shift = exponent - fraction.len() as i32;
        let digits: IBig = digits.parse().ok()?;
        let scale = UBig::from(10u8).pow(shift.unsigned_abs() as usize);
        let value = if shift < 0 { RBig::from_parts(digits, scale) } else { RBig::from(digits * scale) };
        let value = Exact(value);
        value.to_f64().is_finite().then_some(value)
    }

    /// The value of a finite `f64`, exactly.
    pub fn from_f64(value: f64) -> Option<Exact> {
        RBig::try_from(value).ok().map(Exact)
    }

    /// Whether this is 0.
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// Whether this is 1.
    pub fn is_one(&self) -> bool {
        self.0.is_one()
    }

    /// Whether this is 1 or −1.
    pub fn is_unit(&self) -> bool {
        self.is_one() || (-self).is_one()
    }

    /// Whether this is below 0.
    pub fn is_negative(&self) -> bool {
        self.0 < RBig::ZERO
    }

    /// |x|
    pub fn abs(&self) -> Exact {
        if self.is_negative() { -self } else { self.clone() }
    }

    /// 1/x. Panics at zero.
    pub fn recip(&self) -> Exact {
        Exact(RBig::ONE / &self.0)
    }

    /// xⁿ for any n; x must not be zero when n < 0.
    pub fn powi(&self, n: i32) -> Exact {
        Exact(self.0.pow(n as isize))
    }

    /// The integer this is, if it is one that fits.
    pub fn to_i64(&self) -> Option<i64> {
        if !self.0.denominator().is_one() {
            return None;
        }
        i64::try_from(self.0.numerator().clone()).ok()
    }

    /// The nearest `f64`.
    pub fn to_f64(&self) -> f64 {
        self.0.to_f64().value()
    }

    /// The nearest `f32`.
    pub fn to_f32(&self) -> f32 {
        self.0.to_f32().value()
    }

    /// How many bits numerator and denominator take together: what bounds the folding of constants.
    pub fn bits(&self) -> usize {
        use dashu_int::ops::BitTest;
        self.0.numerator().bit_len() + self.0.denominator().bit_len()
    }

    /// Numerator and denominator in decimal, the sign on the numerator.
    pub fn parts(&self) -> (String, String) {
        (self.0.numerator().to_string(), self.0.denominator().to_string())
    }
}

impl From<i64> for Exact {
    fn from(value: i64) -> Exact {
        Exact(RBig::from(value))
    }
}

impl Neg for &Exact {
    type Output = Exact;
    fn neg(self) -> Exact {
        Exact(-self.0.clone())
    }
}

impl Neg for Exact {
    type Output = Exact;
    fn neg(self) -> Exact {
        Exact(-self.0)
    }
}

impl Add for &Exact {
    type Output = Exact;
    fn add(self, other: &Exact) -> Exact {
        Exact(&self.0 + &other.0)
    }
}

impl Sub for &Exact {
    type Output = Exact;
    fn sub(self, other: &Exact) -> Exact {
        Exact(&self.0 - &other.0)
    }
}

impl Mul for &Exact {
    type Output = Exact;
    fn mul(self, other: &Exact) -> Exact {
        if self.is_one() {
            return other.clone();
        }
        if other.is_one() {
            return self.clone();
        }
        Exact(&self.0 * &other.0)
    }
}

impl fmt::Display for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl fmt::Debug for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}
