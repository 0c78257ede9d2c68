//! What acts on islands from outside during a step: gravity, and loads that depend on time and state.

use crate::kernel::bodies::{Rigid, Wrench};
use crate::state::Body;
use nalgebra::{RealField, Vector3};

/// A load on each body at a time since the beginning of the call, s: force and torque, as a function of the
/// body's state.
pub(crate) type LoadAt<'a, R> = &'a (dyn Fn(R, Body, &Rigid<R>) -> Wrench<R> + Sync);

/// What acts during a step.
#[derive(Clone, Copy)]
pub(crate) struct Outside<'a, R: RealField> {
    pub(crate) gravity: Vector3<R>,
    /// The time of the step's start since the beginning of the call, s.
    pub(crate) time: R,
    pub(crate) loads: Option<LoadAt<'a, R>>,
    /// The origin of an island's positions.
    pub(crate) origin: Vector3<f64>,
}
