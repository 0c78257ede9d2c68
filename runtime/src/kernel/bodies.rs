//! Bodies made of nalgebra's vectors, with the memory layout that kernels expect.
//!
//! Kernels read fields by index, as in `a.position[0]`, and quaternions as x, y, z, w, like nalgebra. Kernels
//! of L instances read `a.position[0][lane]`.

use nalgebra::{RealField, UnitQuaternion, Vector3};

/// A rigid body: position of the centre of mass, orientation and velocities, all in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rigid<R: RealField = f64> {
    /// The centre of mass, m.
    pub position: Vector3<R>,
    /// The rotation from body space to the world; a unit quaternion.
    pub orientation: UnitQuaternion<R>,
    /// The velocity of the centre of mass, m/s.
    pub velocity: Vector3<R>,
    /// The angular velocity, rad/s.
    pub angular_velocity: Vector3<R>,
}

/// A rigid body in single precision.
pub type RigidF32 = Rigid<f32>;

/// A point mass: position and velocity in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Particle<R: RealField = f64> {
    /// The position, m.
    pub position: Vector3<R>,
    /// The velocity, m/s.
    pub velocity: Vector3<R>,
}

/// A particle in single precision.
pub type ParticleF32 = Particle<f32>;

/// L rigid bodies, one per instance that a kernel computes at once.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidLanes<R, const L: usize> {
    /// The centres of mass, m.
    pub position: [[R; L]; 3],
    /// The rotations from body space to the world; unit quaternions x, y, z, w.
    pub orientation: [[R; L]; 4],
    /// The velocities of the centres of mass, m/s.
    pub velocity: [[R; L]; 3],
    /// The angular velocities, rad/s.
    pub angular_velocity: [[R; L]; 3],
}

/// L particles, one per instance that a kernel computes at once.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleLanes<R, const L: usize> {
    /// The positions, m.
    pub position: [[R; L]; 3],
    /// The velocities, m/s.
    pub velocity: [[R; L]; 3],
}

/// A force and a torque about the centre of mass, in the world frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<R: RealField = f64> {
    /// The force, N.
    pub force: Vector3<R>,
    /// The torque about the centre of mass, N·m.
    pub torque: Vector3<R>,
}

/// At the origin, without rotation, at rest.
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
