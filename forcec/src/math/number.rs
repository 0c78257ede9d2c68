//! Number types that expressions can be evaluated in: doubles, higher precision, doubles with error bounds,
//! or the text of the computation itself.
//!
//! Code that is generic over these traits (special functions, evaluation of a graph or of a schedule) works
//! with all of them.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A comparison of two reals.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Comparison {
    /// <
    Less,
    /// ≤
    LessEqual,
    /// =
    Equal,
}

/// A floating point format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Precision {
    /// Double precision.
    F64,
    /// Single precision.
    F32,
}

impl Precision {
    /// All precisions, double first.
    pub const ALL: [Precision; 2] = [Precision::F64, Precision::F32];

    /// The name in Rust, which is also the suffix of C names.
    pub fn name(self) -> &'static str {
        match self {
            Precision::F64 => "f64",
            Precision::F32 => "f32",
        }
    }
}

impl fmt::Display for Precision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A type with arithmetic.
pub trait Arithmetic:
    Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The value nearest to an exact number.
    fn exact(value: &Exact) -> Self;

    /// Calls a function of the table.
    fn call(function: Function, arguments: &[Self]) -> Self;

    /// x y + z, with one rounding if the type rounds.
    fn fused(x: Self, y: Self, z: Self) -> Self {
        x * y + z
    }

    /// Number of binary digits of the output format.
    fn digits() -> u32 {
        f64::MANTISSA_DIGITS
    }

    /// The same value with a name, for types that record the computation.
    fn named(self, _name: &str) -> Self {
        self
    }
}

/// A type with arithmetic and comparisons.
pub trait Number: Arithmetic {
    /// The truth value of a comparison.
    fn holds(comparison: Comparison, x: &Self, y: &Self) -> bool;
}

/// xⁿ by repeated squaring.
pub(crate) fn power<N: Number>(x: N, n: u32) -> N {
    let mut product: Option<N> = None;
    let (mut square, mut rest) = (x, n);
    while rest > 0 {
        if rest % 2 == 1 {
            product = Some(match product {
                Some(product) => product * square.clone(),
                None => square.clone(),
            });
        }
        rest /= 2;
        if rest > 0 {
            square = square.clone() * square;
        }
    }
    product.unwrap_or_else(|| N::exact(&Exact::ONE))
}

/// A type that can choose between two computations: numbers compare, a record contains both.
pub trait Choice: Arithmetic {
    /// `less` if x < y, else `otherwise`; the last operation of a computation.
    fn if_less(x: &Self, y: &Self, less: impl FnOnce() -> Self, otherwise: impl FnOnce() -> Self) -> Self;
}

impl<N: Number> Choice for N {
    fn if_less(x: &N, y: &N, less: impl FnOnce() -> N, otherwise: impl FnOnce() -> N) -> N {
        if N::holds(Comparison::Less, x, y) { less() } else { otherwise() }
    }
}

macro_rules! float {
    ($float:ty, $nearest:ident) => {
        impl Arithmetic for $float {
            fn exact(value: &Exact) -> $float {
                value.$nearest()
            }

            fn digits() -> u32 {
                <$float>::MANTISSA_DIGITS
            }

            fn fused(x: $float, y: $float, z: $float) -> $float {
                x.mul_add(y, z)
            }

            fn call(function: Function, arguments: &[$float]) -> $float {
                let wide: Vec<f64> = arguments.iter().map(|&x| f64::from(x)).collect();
                (function.row().value)(&wide) as $float
            }
        }

        impl Number for $float {
            fn holds(comparison: Comparison, x: &$float, y: &$float) -> bool {
                match comparison {
                    Comparison::Less => x < y,
                    Comparison::LessEqual => x <= y,
                    Comparison::Equal => x == y,
                }
            }
        }
    };
}
float!(f64, to_f64);
float!(f32, to_f32);
