//! Functions of the force language that the standard library or nalgebra lack or name differently.

use nalgebra::{Matrix2, Matrix3, RealField, SMatrix, SVector, Vector3};

/// Functions of a real.
pub trait RealFunctions: Sized {
    /// The error function, 2/√π ∫₀ˣ e^(−t²) dt.
    fn erf(self) -> Self;
    /// 1 − erf x, accurate for small results.
    fn erfc(self) -> Self;
    /// sin(x)/x; 1 at 0.
    fn sinc(self) -> Self;
    /// (1 − cos x)/x²; ½ at 0.
    fn versine(self) -> Self;
    /// 1/(1 + e⁻ˣ).
    fn logistic(self) -> Self;
    /// ln(1 + eˣ).
    fn softplus(self) -> Self;
    /// ln cosh x.
    fn ln_cosh(self) -> Self;
}

macro_rules! real_functions {
    ($real:ident, $erf:path, $erfc:path) => {
        impl RealFunctions for $real {
            fn erf(self) -> $real {
                $erf(self)
            }

            fn erfc(self) -> $real {
                $erfc(self)
            }

            fn sinc(self) -> $real {
                if self.abs() < 1e-6 { 1.0 - self * self / 6.0 } else { self.sin() / self }
            }

            fn versine(self) -> $real {
                0.5 * (0.5 * self).sinc().powi(2)
            }

            fn logistic(self) -> $real {
                1.0 / (1.0 + (-self).exp())
            }

            fn softplus(self) -> $real {
                self.max(0.0) + (-self.abs()).exp().ln_1p()
            }

            fn ln_cosh(self) -> $real {
                let a = self.abs();
                if a < 1.0 {
                    let e = a.exp_m1();
                    (e * e / (2.0 + 2.0 * e)).ln_1p()
                } else {
                    a + ((-2.0 * a).exp().ln_1p() - core::$real::consts::LN_2)
                }
            }
        }
    };
}
real_functions!(f64, libm::erf, libm::erfc);
real_functions!(f32, libm::erff, libm::erfcf);

/// The angle between two vectors.
pub trait AngleBetween<R> {
    /// atan2(|u × v|, u · v), 0 … π. nalgebra's `angle` loses digits near 0 and π.
    fn angle_between(&self, v: &Self) -> R;
}

impl<R: RealField + Copy> AngleBetween<R> for Vector3<R> {
    fn angle_between(&self, v: &Vector3<R>) -> R {
        self.cross(v).norm().atan2(self.dot(v))
    }
}

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
    /// The inverse; entries of a singular matrix's inverse are not finite.
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
