//! Numbers that expressions can be evaluated in: doubles, higher precision, doubles with error bounds, or the text of
//! the computation itself.
//!
//! What is written once against these traits (the special functions, the evaluation of a graph or of a schedule) serves
//! all of them.

use crate::math::exact::Exact;
use crate::math::functions::Function;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// How two reals are compared.
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
    /// Doubles.
    F64,
    /// Floats.
    F32,
}

impl Precision {
    /// Both.
    pub const ALL: [Precision; 2] = [Precision::F64, Precision::F32];

    /// Its name, which is Rust's and the suffix of C names.
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

/// What can be computed with.
pub trait Arithmetic:
    Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The nearest to an exact number.
    fn exact(value: &Exact) -> Self;

    /// A row of the function table.
    fn call(function: Function, arguments: &[Self]) -> Self;

    /// x y + z, rounded once where numbers round.
    fn fused(x: Self, y: Self, z: Self) -> Self {
        x * y + z
    }

    /// Binary digits of a number of the format that results are for.
    fn digits() -> u32 {
        f64::MANTISSA_DIGITS
    }

    /// The same value under a name: for those who record the computation.
    fn named(self, _name: &str) -> Self {
        self
    }
}

/// What can be computed with and compared.
pub trait Number: Arithmetic {
    /// Whether a comparison holds.
    fn holds(comparison: Comparison, x: &Self, y: &Self) -> bool;
}

/// What can take one of two ways: numbers by comparing, a record of the computation by writing both down.
pub trait Choice: Arithmetic {
    /// The first way if x < y, else the second; the last thing that a computation does.
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
