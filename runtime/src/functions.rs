//! The functions of the force language that nalgebra spells otherwise.

use nalgebra::{Matrix2, Matrix3, RealField, SMatrix, SVector};

/// The product v wᵀ.
pub trait Outer<R, const N: usize> {
    /// The matrix v wᵀ, called on v.
    fn outer(&self, w: &SVector<R, N>) -> SMatrix<R, N, N>;
}

impl<R: RealField + Copy, const N: usize> Outer<R, N> for SVector<R, N> {
    fn outer(&self, w: &SVector<R, N>) -> SMatrix<R, N, N> {
        self * w.transpose()
    }
}

/// The inverse of a small matrix.
pub trait Inverse {
    /// The inverse; not finite where there is none.
    fn inverse(&self) -> Self;
}

impl<R: RealField + Copy> Inverse for Matrix2<R> {
    fn inverse(&self) -> Matrix2<R> {
        let m = self;
        Matrix2::new(m.m22, -m.m12, -m.m21, m.m11) / m.determinant()
    }
}

impl<R: RealField + Copy> Inverse for Matrix3<R> {
    fn inverse(&self) -> Matrix3<R> {
        let (u, v, w) = (self.column(0), self.column(1), self.column(2));
        let rows = [v.cross(&w).transpose(), w.cross(&u).transpose(), u.cross(&v).transpose()];
        Matrix3::from_rows(&rows) / self.determinant()
    }
}
