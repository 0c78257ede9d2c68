//! Numbers in lanes: L instances of a real, on which all operations act at once.
//!
//! In and out: `Lanes<R, L>`, an array whose loops compilers turn into wide instructions. No operation mixes
//! instances or fuses products with sums, so that an instance has the same bits in any number of lanes.
//! [`wide`] runs an operation with the instructions that the processor has.

use nalgebra::RealField;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// L numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub(crate) struct Lanes<R, const L: usize>(pub(crate) [R; L]);

/// Three numbers per instance.
pub(crate) type Three<R, const L: usize> = [Lanes<R, L>; 3];

macro_rules! operations {
    ($($trait:ident $method:ident $operator:tt),*) => { $(
        impl<R: RealField + Copy, const L: usize> $trait for Lanes<R, L> {
            type Output = Lanes<R, L>;

            #[inline(always)]
            fn $method(mut self, other: Lanes<R, L>) -> Lanes<R, L> {
                for k in 0..L {
                    self.0[k] $operator other.0[k];
                }
                self
            }
        }
    )* };
}
operations!(Add add +=, Sub sub -=, Mul mul *=);

impl<R: RealField + Copy, const L: usize> Neg for Lanes<R, L> {
    type Output = Lanes<R, L>;

    #[inline(always)]
    fn neg(mut self) -> Lanes<R, L> {
        for k in 0..L {
            self.0[k] = -self.0[k];
        }
        self
    }
}

impl<R: RealField + Copy, const L: usize> AddAssign for Lanes<R, L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Lanes<R, L>) {
        *self = *self + other;
    }
}

impl<R: RealField + Copy, const L: usize> SubAssign for Lanes<R, L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Lanes<R, L>) {
        *self = *self - other;
    }
}

impl<R: RealField + Copy, const L: usize> Lanes<R, L> {
    /// The same number for all instances.
    #[inline(always)]
    pub(crate) fn all(x: R) -> Lanes<R, L> {
        Lanes([x; L])
    }

    #[inline(always)]
    pub(crate) fn zero() -> Lanes<R, L> {
        Lanes::all(R::zero())
    }

    /// 1 / x
    #[inline(always)]
    pub(crate) fn recip(mut self) -> Lanes<R, L> {
        for k in 0..L {
            self.0[k] = R::one() / self.0[k];
        }
        self
    }

    #[inline(always)]
    pub(crate) fn sqrt(mut self) -> Lanes<R, L> {
        for k in 0..L {
            self.0[k] = self.0[k].sqrt();
        }
        self
    }

    /// The larger of each pair of absolute values, NaN if the second is NaN.
    #[inline(always)]
    pub(crate) fn max_abs(self, other: Lanes<R, L>) -> Lanes<R, L> {
        self.map_with(other, |a, b| if a.abs() >= b.abs() { a.abs() } else { b.abs() })
    }

    /// `other` where the condition holds.
    #[inline(always)]
    pub(crate) fn or_if(self, other: Lanes<R, L>, condition: [bool; L]) -> Lanes<R, L> {
        Lanes(std::array::from_fn(|k| if condition[k] { other.0[k] } else { self.0[k] }))
    }

    #[inline(always)]
    pub(crate) fn map_with(self, other: Lanes<R, L>, f: impl Fn(R, R) -> R) -> Lanes<R, L> {
        let mut out = self;
        for k in 0..L {
            out.0[k] = f(self.0[k], other.0[k]);
        }
        out
    }
}

/// Fields of bodies, which have arrays, as numbers in lanes.
#[inline(always)]
pub(crate) fn lanes<R: Copy, const L: usize, const N: usize>(arrays: &[[R; L]; N]) -> [Lanes<R, L>; N] {
    arrays.map(Lanes)
}

/// The reverse.
#[inline(always)]
pub(crate) fn arrays<R: Copy, const L: usize, const N: usize>(lanes: [Lanes<R, L>; N]) -> [[R; L]; N] {
    lanes.map(|x| x.0)
}

#[inline(always)]
pub(crate) fn cross<R: RealField + Copy, const L: usize>(a: Three<R, L>, b: Three<R, L>) -> Three<R, L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// An operation that [`wide`] compiles once for each set of instructions; `run` must be inlined always.
pub(crate) trait Operation {
    type Output;
    fn run(self) -> Self::Output;
}

struct Wide<O>(O);

impl<O: Operation> pulp::WithSimd for Wide<O> {
    type Output = O::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> O::Output {
        self.0.run()
    }
}

/// Runs an operation on L instances with the widest instructions of the processor that they fill.
#[inline]
pub(crate) fn wide<R, const L: usize, O: Operation>(arch: pulp::Arch, operation: O) -> O::Output {
    let _ = arch;
    #[cfg(target_arch = "x86_64")]
    match arch {
        pulp::Arch::V4(v4) if L * size_of::<R>() > 32 => return pulp::Simd::vectorize(v4, Wide(operation)),
        pulp::Arch::V4(v4) if L * size_of::<R>() > 16 => return pulp::Simd::vectorize(*v4, Wide(operation)),
        pulp::Arch::V3(v3) if L * size_of::<R>() > 16 => return pulp::Simd::vectorize(v3, Wide(operation)),
        _ => {}
    }
    // What every processor of this kind has.
    operation.run()
}

/// The number of lanes that fill the widest instructions of the processor.
pub(crate) fn widest<R>() -> usize {
    let bytes = match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(_) => 64,
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(_) => 32,
        _ => 16,
    };
    (bytes / size_of::<R>()).min(8)
}
