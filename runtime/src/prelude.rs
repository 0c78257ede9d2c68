//! The names used in force functions, in double precision: `use forcec_runtime::prelude::*`.

pub use crate::kernel::bodies::{Particle, Rigid, Wrench};
pub use crate::kernel::functions::{AngleBetween, Inverse, Outer, RealFunctions};
#[cfg(feature = "macros")]
pub use forcec_macros::{constraint, domain, energy, force, forces, include_forces};
pub use std::f64::consts::PI;

/// A real number.
pub type Real = f64;
/// Two reals.
pub type Vec2 = nalgebra::Vector2<Real>;
/// Three reals.
pub type Vec3 = nalgebra::Vector3<Real>;
/// Four reals.
pub type Vec4 = nalgebra::Vector4<Real>;
/// A 2 × 2 matrix.
pub type Mat2 = nalgebra::Matrix2<Real>;
/// A 3 × 3 matrix.
pub type Mat3 = nalgebra::Matrix3<Real>;
/// A rotation as a unit quaternion.
pub type Quat = nalgebra::UnitQuaternion<Real>;
