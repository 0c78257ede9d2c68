//! Dense D × D blocks of a sparse matrix, stored row by row, as kernels write them.
//!
//! Loops over rows have constant length, so compilers vectorise them. No pivoting.

use nalgebra::{Matrix3, RealField, SVector};

/// A D × D block, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block<R, const D: usize>(pub(crate) [[R; D]; D]);

impl<R: RealField + Copy, const D: usize> Block<R, D> {
    pub(crate) fn zeros() -> Block<R, D> {
        Block([[R::zero(); D]; D])
    }

    /// Adds a 3 × 3 block to the rotational rows and columns; does nothing for D = 3.
    #[inline]
    pub(crate) fn add_turning(&mut self, change: &Matrix3<R>) {
        for i in 3..D {
            for j in 3..D {
                self.0[i][j] += change[(i - 3, j - 3)];
            }
        }
    }

    /// A x
    #[inline(always)]
    pub(crate) fn times(&self, x: &SVector<R, D>) -> SVector<R, D> {
        let mut product = SVector::<R, D>::zeros();
        for (entry, row) in product.iter_mut().zip(&self.0) {
            for (&a, &x) in row.iter().zip(x.iter()) {
                *entry += a * x;
            }
        }
        product
    }

    /// Aᵀ x
    pub(crate) fn transposed_times(&self, x: &SVector<R, D>) -> SVector<R, D> {
        let mut product = SVector::<R, D>::zeros();
        for (row, &x) in self.0.iter().zip(x.iter()) {
            for (entry, &a) in product.iter_mut().zip(row) {
                *entry += a * x;
            }
        }
        product
    }

    /// A −= B C
    #[inline]
    pub(crate) fn subtract_product(&mut self, b: &Block<R, D>, c: &Block<R, D>) {
        for k in 0..D {
            let row = c.0[k];
            for (sum, factors) in self.0.iter_mut().zip(&b.0) {
                subtract(sum, factors[k], &row);
            }
        }
    }

    /// A = L U in place, with ones on the diagonal of L; stores the inverted diagonal of U.
    #[inline]
    #[expect(
        clippy::needless_range_loop,
        reason = "all ranges are constant: it becomes straight code, twice as fast"
    )]
    pub(crate) fn factor(&mut self) {
        let a = &mut self.0;
        for k in 0..D {
            let inverse = R::one() / a[k][k];
            a[k][k] = inverse;
            for i in k + 1..D {
                let factor = a[i][k] * inverse;
                a[i][k] = factor;
                for j in k + 1..D {
                    let top = a[k][j];
                    a[i][j] -= factor * top;
                }
            }
        }
    }

    /// X becomes A⁻¹ X, where `self` contains the factors of A.
    #[inline]
    pub(crate) fn solve_block(&self, x: &mut Block<R, D>) {
        for k in 0..D {
            let top = x.0[k];
            for i in k + 1..D {
                subtract(&mut x.0[i], self.0[i][k], &top);
            }
        }
        for k in (0..D).rev() {
            let inverse = self.0[k][k];
            x.0[k].iter_mut().for_each(|x| *x *= inverse);
            let bottom = x.0[k];
            for i in 0..k {
                subtract(&mut x.0[i], self.0[i][k], &bottom);
            }
        }
    }

    /// x becomes A⁻¹ x, where `self` contains the factors of A.
    #[inline]
    pub(crate) fn solve(&self, x: &mut SVector<R, D>) {
        let (a, mut y) = (&self.0, *x);
        for k in 0..D {
            for i in k + 1..D {
                let known = y[k];
                y[i] -= a[i][k] * known;
            }
        }
        for k in (0..D).rev() {
            y[k] *= a[k][k];
            for i in 0..k {
                let known = y[k];
                y[i] -= a[i][k] * known;
            }
        }
        *x = y;
    }
}

/// x −= factor y
#[inline(always)]
fn subtract<R: RealField + Copy, const D: usize>(x: &mut [R; D], factor: R, y: &[R; D]) {
    for (x, &y) in x.iter_mut().zip(y) {
        *x -= factor * y;
    }
}
