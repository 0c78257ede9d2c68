//! The data of the methods: velocities and poses at the start and in the stages, and dense output.
//!
//! Input: an assembly, whose nodes are the dynamic bodies of an island. Output: the arrays that the methods
//! write, all with one vector per node, reused in every step; after a step of `Rodas4` also the state at any
//! time within that step.

use crate::kernel::BodyKind;
use crate::kernel::bodies::Rigid;
use crate::state::moved;
use crate::system::assemble::Assembly;
use crate::system::inertia::{angular, linear};
use crate::system::iterative::Workspace;
use nalgebra::{Matrix3, RealField, SVector};

/// The data of a method, reused in every step.
pub(crate) struct Model<R: RealField, const D: usize> {
    pub(crate) assembly: Assembly<R, D>,
    pub(super) space: Workspace<R, D>,
    /// Velocities at the start of the step.
    pub(super) start: Vec<SVector<R, D>>,
    pub(super) velocity: Vec<SVector<R, D>>,
    /// Poses of a stage.
    pub(super) pose: Vec<SVector<R, D>>,
    /// The result of each stage, for poses and for velocities.
    pub(super) stages: [[Vec<SVector<R, D>>; 6]; 2],
    /// The rates of the generalised-α method: a and v̇.
    pub(super) rates: [Vec<SVector<R, D>>; 2],
    /// The two polynomial terms of dense output, for poses and for velocities.
    pub(super) dense: [[Vec<SVector<R, D>>; 2]; 2],
    /// The change of poses and velocities in a whole step.
    pub(super) change: [Vec<SVector<R, D>>; 2],
    /// ∂f/∂t, and the matrix B of each body in the Rosenbrock method.
    pub(super) driven: Vec<SVector<R, D>>,
    pub(super) rotation_maps: Vec<Matrix3<R>>,
}

impl<R: RealField + Copy, const D: usize> Model<R, D> {
    pub(crate) fn new(assembly: Assembly<R, D>) -> Model<R, D> {
        Model {
            assembly,
            space: Workspace::default(),
            start: Vec::new(),
            velocity: Vec::new(),
            pose: Vec::new(),
            stages: Default::default(),
            rates: Default::default(),
            dense: Default::default(),
            change: Default::default(),
            driven: Vec::new(),
            rotation_maps: Vec::new(),
        }
    }

    /// A body at a fraction `alpha` of the last step; `None` unless that was a step of `Rodas4`.
    pub(crate) fn interpolate(
        &self,
        kind: BodyKind,
        index: usize,
        alpha: R,
        saved: Rigid<R>,
    ) -> Option<Rigid<R>> {
        let node = self.assembly.nodes[kind as usize].get(index).copied()??;
        let at = |part: usize| {
            let [third, fourth] = self.dense[part].each_ref().map(|terms| terms.get(node));
            let correction = (third? + fourth? * alpha) * (R::one() - alpha);
            Some((self.change[part].get(node)? + correction) * alpha)
        };
        let (pose, velocity) = (at(0)?, at(1)?);
        let body = moved(&saved, linear(&pose), angular(&pose));
        Some(Rigid {
            velocity: saved.velocity + linear(&velocity),
            angular_velocity: saved.angular_velocity + angular(&velocity),
            ..body
        })
    }
}
