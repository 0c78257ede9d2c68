//! Bodies over nalgebra's vectors, laid out as the bodies of kernels are.
//!
//! A kernel reads a body's fields by index, `a.position[0]`; nalgebra stores a quaternion x, y, z, w, as kernels do.

use nalgebra::{RealField, UnitQuaternion, Vector3};

/// A rigid body: where its centre of mass is, how it is turned, and how it moves, all in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rigid<R: RealField = f64> {
    /// The centre of mass.
    pub position: Vector3<R>,
    /// From body space to the world; taken as unit.
    pub orientation: UnitQuaternion<R>,
    /// Of the centre of mass.
    pub velocity: Vector3<R>,
    /// About the centre of mass.
    pub angular_velocity: Vector3<R>,
}

/// A rigid body in single precision.
pub type RigidF32 = Rigid<f32>;

/// A point mass: where it is and how it moves, in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Particle<R: RealField = f64> {
    /// Where it is.
    pub position: Vector3<R>,
    /// How it moves.
    pub velocity: Vector3<R>,
}

/// A particle in single precision.
pub type ParticleF32 = Particle<f32>;

/// A force, and a torque about the centre of mass, in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<R: RealField = f64> {
    /// The force.
    pub force: Vector3<R>,
    /// The torque about the centre of mass.
    pub torque: Vector3<R>,
}

/// At the origin, not turned, at rest.
impl<R: RealField + Copy> Default for Rigid<R> {
    fn default() -> Rigid<R> {
        let zero = Vector3::zeros();
        Rigid {
            position: zero,
            orientation: UnitQuaternion::identity(),
            velocity: zero,
            angular_velocity: zero,
        }
    }
}

/// At the origin, at rest.
impl<R: RealField + Copy> Default for Particle<R> {
    fn default() -> Particle<R> {
        Particle { position: Vector3::zeros(), velocity: Vector3::zeros() }
    }
}

/// No force, no torque.
impl<R: RealField + Copy> Default for Wrench<R> {
    fn default() -> Wrench<R> {
        Wrench { force: Vector3::zeros(), torque: Vector3::zeros() }
    }
}
