//! Exact rational numbers: every literal and coefficient, from the source text to the printed kernel.
//!
//! In: decimal literals and small integers. Out: arithmetic without rounding, and the nearest `f64` or `f32`
//! once, when a kernel is printed. Invariant: numbers are in lowest terms, so equal numbers are equal values.
//!
//! A number of more than `MOST_BITS` bits is rounded to `PRECISION` bits; checks and kernels cannot tell the
//! difference. A number beyond 2^±`RANGE` becomes `Beyond`, as does every result computed from it. So
//! arithmetic is fast for any source.

use crate::math::number::Precision;
use dashu_int::ops::{BitTest, PowerOfTwo};
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};

/// A rational number in lowest terms.
///
/// A small fraction, as nearly every coefficient is, is stored inline; any other is on the heap.
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Exact(Repr);

#[derive(Clone, PartialEq, Eq, Hash)]
enum Repr {
    /// Numerator and denominator, in lowest terms.
    Small(i32, u32),
    /// A number that does not fit `Small`.
    Large(Box<RBig>),
    /// Too large or too small to be represented.
    Beyond,
}

/// Maximum number of bits of numerator and denominator together.
const MOST_BITS: usize = 4096;

/// The bits of a number that is rounded.
const PRECISION: isize = 1024;

/// Largest binary exponent of a rounded number, of either sign.
const RANGE: isize = 3000;

/// A multiple whose coefficient's power would leave 2^±this is raised as a whole; half the range of `f32`.
const POWER_RANGE: u64 = 60;

impl Exact {
    /// 0
    pub const ZERO: Exact = Exact(Repr::Small(0, 1));
    /// 1
    pub const ONE: Exact = Exact(Repr::Small(1, 1));

    /// `numerator / denominator`. Panics if the denominator is zero.
    pub fn ratio(numerator: i64, denominator: u64) -> Exact {
        Exact::reduced(numerator.into(), denominator.into())
    }

    /// A fraction in lowest terms, in the small form if it fits.
    fn reduced(numerator: i128, denominator: u128) -> Exact {
        assert!(denominator != 0, "a denominator is not zero");
        let divisor = if denominator == 1 { 1 } else { gcd(numerator.unsigned_abs(), denominator) };
        let (numerator, denominator) = (numerator / divisor as i128, denominator / divisor);
        match (i32::try_from(numerator), u32::try_from(denominator)) {
            (Ok(numerator), Ok(denominator)) => Exact(Repr::Small(numerator, denominator)),
            _ => Exact::of(RBig::from_parts(IBig::from(numerator), UBig::from(denominator))),
        }
    }

    /// A rational of any size, in the small form if it fits.
    fn of(value: RBig) -> Exact {
        match (i32::try_from(value.numerator().clone()), u32::try_from(value.denominator().clone())) {
            (Ok(numerator), Ok(denominator)) => Exact(Repr::Small(numerator, denominator)),
            _ => Exact(Repr::Large(Box::new(value))),
        }
    }

    /// The result of an operation, rounded if it is long.
    fn bounded(value: RBig) -> Exact {
        let (over, under) = (value.numerator().bit_len(), value.denominator().bit_len());
        if over + under <= MOST_BITS {
            return Exact::of(value);
        }
        let exponent = over as isize - under as isize;
        if exponent.abs() > RANGE {
            return Exact(Repr::Beyond);
        }
        let (over, under) = value.into_parts();
        let shift = PRECISION - exponent;
        let (over, under) = (over << shift.max(0) as usize, under << (-shift).max(0) as usize);
        let digits = over / IBig::from(under);
        let scale = UBig::ONE << shift.unsigned_abs();
        Exact::of(match shift {
            ..0 => RBig::from(digits * scale),
            _ => RBig::from_parts(digits, scale),
        })
    }

    /// The value as a rational; `None` if it is out of range.
    fn large(&self) -> Option<RBig> {
        match &self.0 {
            Repr::Small(numerator, denominator) => {
                Some(RBig::from_parts(IBig::from(*numerator), UBig::from(*denominator)))
            }
            Repr::Large(value) => Some((**value).clone()),
            Repr::Beyond => None,
        }
    }

    /// The result of an operation on two rationals.
    fn both(&self, other: &Exact, operation: impl Fn(RBig, RBig) -> RBig) -> Exact {
        match (self.large(), other.large()) {
            (Some(x), Some(y)) => Exact::bounded(operation(x, y)),
            _ => Exact(Repr::Beyond),
        }
    }

    /// Whether this is too large or too small to be represented: a constant that no kernel can print.
    pub fn is_beyond(&self) -> bool {
        matches!(self.0, Repr::Beyond)
    }

    /// Whether |x|ⁿ stays in the range of every precision, with room for further factors.
    pub(crate) fn power_stays(&self, n: u32) -> bool {
        let exponent = match &self.0 {
            Repr::Small(over, under) => over.unsigned_abs().max(1).ilog2().abs_diff(under.ilog2()) as usize,
            Repr::Large(value) => value.numerator().bit_len().abs_diff(value.denominator().bit_len()),
            Repr::Beyond => return false,
        };
        (exponent as u64).saturating_mul(n.into()) <= POWER_RANGE
    }

    /// The value of a decimal literal such as `12`, `0.5`, `1e-3` or `1_000.0`, without suffix.
    /// `None` for other texts, and for numbers beyond the range of `f64` or of more than a thousand digits.
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
        let value = Exact::of(value);
        value.to_f64().is_finite().then_some(value)
    }

    /// The exact value of an `f64`; `None` if it is not finite.
    pub fn from_f64(value: f64) -> Option<Exact> {
        RBig::try_from(value).ok().map(Exact::of)
    }

    /// Whether this is 0.
    pub fn is_zero(&self) -> bool {
        matches!(self.0, Repr::Small(0, _))
    }

    /// Whether this is 1.
    pub fn is_one(&self) -> bool {
        matches!(self.0, Repr::Small(1, 1))
    }

    /// Whether this is 1 or −1.
    pub fn is_unit(&self) -> bool {
        matches!(self.0, Repr::Small(1 | -1, 1))
    }

    /// Whether this is ±2ⁿ for an integer n: multiplying by it is exact.
    pub fn is_power_of_two(&self) -> bool {
        match &self.0 {
            Repr::Small(numerator, denominator) => {
                numerator.unsigned_abs().is_power_of_two() && denominator.is_power_of_two()
            }
            Repr::Large(value) => {
                let (_, numerator) = value.numerator().clone().into_parts();
                numerator.is_power_of_two() && value.denominator().is_power_of_two()
            }
            Repr::Beyond => false,
        }
    }

    /// Whether this is below 0.
    pub fn is_negative(&self) -> bool {
        match &self.0 {
            Repr::Small(numerator, _) => *numerator < 0,
            Repr::Large(value) => **value < RBig::ZERO,
            Repr::Beyond => false,
        }
    }

    /// |x| as a fraction of two integers that every precision represents exactly, if there is one.
    pub(crate) fn whole(&self) -> Option<(Exact, Exact)> {
        const MOST: i64 = 1 << 24;
        let (over, under) = self.abs().parts();
        let small = |text: String| text.parse::<i64>().ok().filter(|n| *n < MOST).map(Exact::from);
        Some((small(over)?, small(under)?))
    }

    /// |x|
    pub fn abs(&self) -> Exact {
        if self.is_negative() { -self } else { self.clone() }
    }

    /// 1/x. Panics at zero.
    pub fn recip(&self) -> Exact {
        match &self.0 {
            Repr::Small(1 | -1, 1) => self.clone(),
            Repr::Small(numerator, denominator) => Exact::reduced(
                i128::from(*denominator) * i128::from(numerator.signum()),
                numerator.unsigned_abs().into(),
            ),
            Repr::Large(value) => Exact::of(RBig::ONE / &**value),
            Repr::Beyond => self.clone(),
        }
    }

    /// xⁿ for any integer n; x must not be zero if n < 0.
    pub fn powi(&self, n: i32) -> Exact {
        let (base, n) = (if n < 0 { self.recip() } else { self.clone() }, n.unsigned_abs());
        let Some(highest) = n.checked_ilog2() else { return Exact::ONE };
        (0..highest).rev().fold(base.clone(), |power, bit| {
            let square = &power * &power;
            if n >> bit & 1 == 1 { &square * &base } else { square }
        })
    }

    /// The value as an integer, if it is an integer that fits.
    pub fn to_i64(&self) -> Option<i64> {
        match &self.0 {
            Repr::Small(numerator, denominator) => (*denominator == 1).then_some((*numerator).into()),
            Repr::Large(value) if value.denominator().is_one() => {
                i64::try_from(value.numerator().clone()).ok()
            }
            Repr::Large(_) | Repr::Beyond => None,
        }
    }

    /// The nearest `f64`; NaN if out of range.
    pub fn to_f64(&self) -> f64 {
        self.large().map_or(f64::NAN, |value| value.to_f64().value())
    }

    /// The nearest `f32`; NaN if out of range.
    pub fn to_f32(&self) -> f32 {
        self.large().map_or(f32::NAN, |value| value.to_f32().value())
    }

    /// Whether a precision represents this without overflow, underflow or a subnormal that loses digits.
    pub fn fits(&self, precision: Precision) -> bool {
        let (nearest, least) = match precision {
            Precision::F64 => (self.to_f64(), f64::MIN_POSITIVE),
            Precision::F32 => (f64::from(self.to_f32()), f64::from(f32::MIN_POSITIVE)),
        };
        nearest.is_finite() && (nearest.abs() >= least || Exact::from_f64(nearest).as_ref() == Some(self))
    }

    /// The approximate binary logarithm of |x|.
    pub(crate) fn exponent(&self) -> i64 {
        self.large().map_or(0, |x| x.numerator().bit_len() as i64 - x.denominator().bit_len() as i64)
    }

    /// A text for messages: the nearest double, or the order of magnitude if that double is not normal.
    pub(crate) fn about(&self) -> String {
        let near = self.to_f64();
        match near.is_normal() || self.is_zero() {
            true => format!("{near:?}"),
            false => format!(
                "about {}1e{}",
                if self.is_negative() { "-" } else { "" },
                self.exponent() * 3010 / 10000
            ),
        }
    }

    /// The bits of numerator and denominator together; they limit the folding of constants.
    pub fn bits(&self) -> usize {
        match &self.0 {
            Repr::Small(numerator, denominator) => {
                let zeros = numerator.unsigned_abs().leading_zeros() + denominator.leading_zeros();
                64 - zeros as usize
            }
            Repr::Large(value) => value.numerator().bit_len() + value.denominator().bit_len(),
            Repr::Beyond => MOST_BITS,
        }
    }

    /// Numerator and denominator in decimal, the sign on the numerator.
    pub fn parts(&self) -> (String, String) {
        match &self.0 {
            Repr::Small(numerator, denominator) => (numerator.to_string(), denominator.to_string()),
            Repr::Large(value) => (value.numerator().to_string(), value.denominator().to_string()),
            Repr::Beyond => ("beyond".to_owned(), "1".to_owned()),
        }
    }
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Ord for Exact {
    fn cmp(&self, other: &Exact) -> Ordering {
        match (&self.0, &other.0) {
            (Repr::Small(a, b), Repr::Small(c, d)) => {
                (i64::from(*a) * i64::from(*d)).cmp(&(i64::from(*c) * i64::from(*b)))
            }
            // A number out of range is less than all others.
            _ => self.large().cmp(&other.large()),
        }
    }
}

impl PartialOrd for Exact {
    fn partial_cmp(&self, other: &Exact) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl From<i64> for Exact {
    fn from(value: i64) -> Exact {
        Exact::ratio(value, 1)
    }
}

impl Neg for &Exact {
    type Output = Exact;
    fn neg(self) -> Exact {
        match &self.0 {
            Repr::Small(numerator, denominator) if *numerator != i32::MIN => {
                Exact(Repr::Small(-numerator, *denominator))
            }
            _ => self.large().map_or(Exact(Repr::Beyond), |value| Exact::of(-value)),
        }
    }
}

impl Neg for Exact {
    type Output = Exact;
    fn neg(self) -> Exact {
        -&self
    }
}

impl Add for &Exact {
    type Output = Exact;
    fn add(self, other: &Exact) -> Exact {
        match (&self.0, &other.0) {
            (Repr::Small(a, b), Repr::Small(c, d)) => {
                let (a, b, c, d) = (i128::from(*a), i128::from(*b), i128::from(*c), i128::from(*d));
                Exact::reduced(a * d + c * b, (b * d) as u128)
            }
            _ => self.both(other, |x, y| x + y),
        }
    }
}

impl Sub for &Exact {
    type Output = Exact;
    fn sub(self, other: &Exact) -> Exact {
        self + &-other
    }
}

impl Mul for &Exact {
    type Output = Exact;
    fn mul(self, other: &Exact) -> Exact {
        match (&self.0, &other.0) {
            (Repr::Small(1, 1), _) => other.clone(),
            (_, Repr::Small(1, 1)) => self.clone(),
            (Repr::Small(a, b), Repr::Small(c, d)) => {
                Exact::reduced(i128::from(*a) * i128::from(*c), u128::from(*b) * u128::from(*d))
            }
            (Repr::Small(0, _), _) | (_, Repr::Small(0, _)) if !self.is_beyond() && !other.is_beyond() => {
                Exact::ZERO
            }
            _ => self.both(other, |x, y| x * y),
        }
    }
}

impl fmt::Display for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.large() {
            Some(value) => write!(f, "{value}"),
            None => write!(f, "beyond"),
        }
    }
}

impl fmt::Debug for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Σ coefficient · term with each term once, in order, without zeros.
pub(crate) fn collect<T: Ord + Copy>(mut terms: Vec<(Exact, T)>) -> Vec<(Exact, T)> {
    terms.sort_by_key(|(_, term)| *term);
    terms.dedup_by(|later, earlier| {
        let same = later.1 == earlier.1;
        if same {
            earlier.0 = &earlier.0 + &later.0;
        }
        same
    });
    terms.retain(|(c, _)| !c.is_zero());
    terms
}

#[cfg(test)]
mod tests {
    use super::Exact;

    /// Numbers stay short and accurate in long computations.
    #[test]
    fn numbers_stay_short() {
        let third = Exact::ratio(1, 3);
        // x = x/3 + 1/7 tends to 3/14.
        let seventh = Exact::ratio(1, 7);
        let mut x = Exact::ratio(1, 10);
        for _ in 0..5000 {
            x = &(&x * &third) + &seventh;
            assert!(x.bits() <= 4096 && !x.is_beyond());
        }
        assert!((&x - &Exact::ratio(3, 14)).abs() < Exact::ratio(1, 1 << 60).powi(10));
        // Newton's iteration for √2, which doubles the number of digits.
        let (half, two) = (Exact::ratio(1, 2), Exact::from(2));
        let mut z = Exact::ONE;
        for _ in 0..40 {
            z = &half * &(&z + &(&two * &z.recip()));
        }
        assert!((&(&z * &z) - &two).abs() < Exact::ratio(1, 1 << 60).powi(10));
        assert_eq!(z.to_f64(), 2f64.sqrt());
        // Powers: exact if short, rounded if long, `Beyond` if out of range.
        let tenth = Exact::ratio(11, 10);
        let exact = (0..300).fold(Exact::ONE, |power, _| &power * &tenth);
        assert_eq!(tenth.powi(300), exact);
        assert_eq!(tenth.powi(-300), exact.recip());
        let close = Exact::parse("1.0000000001").expect("a literal");
        assert!((close.powi(1_000_000_000).to_f64() / 0.1f64.exp() - 1.0).abs() < 1e-10);
        for far in [tenth.powi(2_000_000_000), tenth.powi(i32::MIN), half.powi(i32::MAX)] {
            assert!(far.is_beyond() && (&far * &Exact::ZERO).is_beyond() && far.recip().is_beyond());
            assert!((&far - &far).is_beyond() && far.to_f64().is_nan() && far.bits() <= 4096);
        }
        assert_eq!(tenth.powi(0), Exact::ONE);
    }
}
