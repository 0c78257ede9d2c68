//! The traits that connect kernels with the runtime; the macros implement them next to the kernel's module.
//!
//! The `Output` of a kernel implements [`Kernel`]. A kernel reads bodies in place, from arrays by index.

pub mod bodies;
pub mod functions;

use crate::kernel::bodies::{Particle, ParticleLanes, Rigid, RigidLanes};
use nalgebra::RealField;

/// A body type.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyKind {
    /// [`Rigid`], six degrees of freedom: position, then rotation.
    Rigid,
    /// [`Particle`], three degrees of freedom: position.
    Particle,
}

impl BodyKind {
    /// The number of degrees of freedom.
    pub const fn dofs(self) -> usize {
        match self {
            BodyKind::Rigid => 6,
            BodyKind::Particle => 3,
        }
    }
}

/// A list of numbers, to which parameters are written. Generated code uses this name, so it needs no `std`.
pub type Numbers<R> = Vec<R>;

/// All bodies, in one array per type.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a, R: RealField> {
    /// Rigid bodies.
    pub rigid: &'a [Rigid<R>],
    /// Particles.
    pub particles: &'a [Particle<R>],
}

/// All bodies of L equal systems, in one array per type.
#[derive(Clone, Copy, Debug)]
pub struct BodiesLanes<'a, R, const L: usize> {
    /// Rigid bodies.
    pub rigid: &'a [RigidLanes<R, L>],
    /// Particles.
    pub particles: &'a [ParticleLanes<R, L>],
}

/// A kernel: a force and its derivatives as a function of bodies and parameters.
pub trait Kernel: Clone + Default + Send + 'static {
    /// The precision of the kernel's operations.
    type Real: RealField + Copy;
    /// The parameters; `()` for a kernel without parameters.
    type Params: Clone + Send + 'static;
    /// The index of each body, `[usize; n]`.
    type Indices: Copy + Default + AsRef<[usize]> + AsMut<[usize]> + Send + 'static;
    /// The name of the force function.
    const NAME: &'static str;
    /// The types of the bodies, in argument order.
    const BODIES: &'static [BodyKind];
    /// N, the number of degrees of freedom of all bodies.
    const DOFS: usize;
    /// For each row of ∂F/∂X a string of N characters; `.` marks an entry that is always zero.
    const DFDX_NONZERO: &'static [&'static str];
    /// The same for ∂F/∂V.
    const DFDV_NONZERO: &'static [&'static str];

    /// Computes force and derivatives for the bodies at these indices into the arrays of their types.
    ///
    /// Panics if an index is out of range.
    fn evaluate(&mut self, bodies: &Bodies<'_, Self::Real>, indices: Self::Indices, params: &Self::Params);

    /// F, N entries: the bodies in argument order.
    fn force(&self) -> &[Self::Real];

    /// ∂F/∂X, N² entries row by row.
    fn dfdx(&self) -> &[Self::Real];

    /// ∂F/∂V, N² entries row by row.
    fn dfdv(&self) -> &[Self::Real];

    /// The buffer of [`Kernel::evaluate_force`].
    type Force: Clone + Default + Send + 'static;

    /// Computes F only, N entries, faster than [`Kernel::evaluate`].
    fn evaluate_force<'a>(
        out: &'a mut Self::Force,
        bodies: &Bodies<'_, Self::Real>,
        indices: Self::Indices,
        params: &Self::Params,
    ) -> &'a [Self::Real];

    /// The parameters of L instances, for [`Kernel::force_lanes`]; `()` without parameters.
    type LaneParams<const L: usize>: Clone + Send + 'static;

    /// The parameters of L instances, one instance per lane.
    fn gather_params<const L: usize>(each: [&Self::Params; L]) -> Self::LaneParams<L>;

    /// The buffer of [`Kernel::force_lanes`].
    type LaneForce<const L: usize>: Clone + Default + Send + 'static;

    /// Computes F of L instances, N entries, each with one number per instance. The indices are the same for
    /// all instances. The numbers of an instance have the same bits for every L, also for L = 1; they are those
    /// of [`Kernel::evaluate_force`] up to rounding.
    ///
    /// Always inlined, so that the caller's CPU features apply. Panics if an index is out of range.
    fn force_lanes<'a, const L: usize>(
        out: &'a mut Self::LaneForce<L>,
        bodies: &BodiesLanes<'_, Self::Real, L>,
        indices: Self::Indices,
        params: &Self::LaneParams<L>,
    ) -> &'a [[Self::Real; L]];

    /// For each row of C a string of N characters; `.` marks an entry of J that is always zero.
    const JACOBIAN_NONZERO: &'static [&'static str] = &[];

    /// The parameters of L instances, for [`Kernel::rows_lanes`]: those that C depends on.
    type RowParams<const L: usize>: Clone + Send + 'static;

    /// The parameters that C depends on of L instances, one instance per lane.
    fn gather_row_params<const L: usize>(each: [&Self::Params; L]) -> Self::RowParams<L>;

    /// The buffer of [`Kernel::rows_lanes`].
    type LaneRows<const L: usize>: Clone + Default + Send + 'static;

    /// Computes the rows of a constraint for L instances, whatever its stiffness and damping; empty for
    /// energies and forces.
    ///
    /// Always inlined, so that the caller's CPU features apply. Panics if an index is out of range.
    #[inline(always)]
    fn rows_lanes<'a, const L: usize>(
        _out: &'a mut Self::LaneRows<L>,
        _bodies: &BodiesLanes<'_, Self::Real, L>,
        _indices: Self::Indices,
        _params: &Self::RowParams<L>,
    ) -> Rows<'a, Self::Real, L> {
        Rows { value: &[], jacobian: &[], drift: &[] }
    }

    /// The buffer of [`Kernel::saddle`].
    type Saddle: Clone + Default + Send + 'static;

    /// Computes the rows of a constraint and the geometric stiffness of [`Kernel::ROWS`] given `multipliers`,
    /// whatever the stiffness and damping; empty for energies and forces.
    ///
    /// Panics if there are fewer multipliers, or if an index is out of range.
    fn saddle<'a>(
        _out: &'a mut Self::Saddle,
        _bodies: &Bodies<'_, Self::Real>,
        _indices: Self::Indices,
        _params: &Self::Params,
        _multipliers: &[Self::Real],
    ) -> Saddle<'a, Self::Real> {
        Saddle { value: &[], jacobian: &[], geometric: &[] }
    }

    /// The buffer of [`Kernel::evaluate_step`].
    type Step: Clone + Default + Send + 'static;

    /// The number of rows of C, each with a multiplier λ = stiffness C + damping Ċ; 0 for energies and
    /// forces.
    const ROWS: usize = 0;
    /// Whether λ is clamped to λ ≤ 0.
    const ONE_SIDED: bool = false;

    /// Computes the linearised force for a step of h s, faster than both derivatives. The [`Kernel::ROWS`]
    /// `multipliers` replace λ in the derivatives of the gradients of C, so that stretched joints do not
    /// spoil the matrix.
    ///
    /// Panics if there are fewer multipliers, or if an index is out of range.
    fn evaluate_step<'a>(
        out: &'a mut Self::Step,
        bodies: &Bodies<'_, Self::Real>,
        indices: Self::Indices,
        params: &Self::Params,
        step: Self::Real,
        multipliers: &[Self::Real],
    ) -> Linear<'a, Self::Real>;

    /// Sets stiffness and damping, of all rows; returns whether these are parameters.
    fn set_penalty(_params: &mut Self::Params, _stiffness: Self::Real, _damping: Self::Real) -> bool {
        false
    }

    /// Whether [`Kernel::measure`] returns a potential: true for constraints and energies.
    const HAS_POTENTIAL: bool = false;

    /// The potential energy and the constraint violation of the bodies at these indices.
    fn measure(
        _bodies: &Bodies<'_, Self::Real>,
        _indices: Self::Indices,
        _params: &Self::Params,
    ) -> Measure<Self::Real> {
        Measure::default()
    }

    /// Appends the parameters as numbers, in source order.
    fn write_params(params: &Self::Params, numbers: &mut Vec<Self::Real>);

    /// Reads parameters that `write_params` wrote; `None` if there are too few numbers.
    fn read_params(numbers: &mut dyn Iterator<Item = Self::Real>) -> Option<Self::Params>;
}

/// The rows of a constraint for L instances; each entry has one number per instance.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, R, const L: usize> {
    /// C, one entry per row.
    pub value: &'a [[R; L]],
    /// J = ∂C/∂X, N entries per row of C, row by row.
    pub jacobian: &'a [[R; L]],
    /// D(J V) V, the part of d²C/dt² that does not depend on accelerations: one entry per row.
    pub drift: &'a [[R; L]],
}

/// The rows of a constraint with given multipliers, for implicit methods.
#[derive(Clone, Copy, Debug)]
pub struct Saddle<'a, R> {
    /// C, one entry per row.
    pub value: &'a [R],
    /// J = ∂C/∂X, N entries per row of C, row by row.
    pub jacobian: &'a [R],
    /// The derivative of Jᵀ λ along the pose coordinates for constant λ: N² entries row by row.
    pub geometric: &'a [R],
}

/// A force linearised for a step of h s.
#[derive(Clone, Copy, Debug)]
pub struct Linear<'a, R> {
    /// F, N entries.
    pub force: &'a [R],
    /// h ∂F/∂V + h² ∂F/∂X, with given multipliers in derivatives of gradients of C: N² entries row by row.
    pub matrix: &'a [R],
    /// λ, one entry per row of C.
    pub multipliers: &'a [R],
    /// h ∂λ/∂V + h² ∂λ/∂X, N entries per row of C.
    pub slopes: &'a [R],
}

/// The stored energy of a constraint or an energy, and the violation of a constraint.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measure<R> {
    /// The potential energy, J: ½ stiffness C² summed over rows, or E.
    pub energy: R,
    /// The largest |C| over the rows, or over the rows that push if unilateral; zero for an energy.
    pub max_violation: R,
}

impl<R: RealField> Default for Measure<R> {
    fn default() -> Measure<R> {
        Measure { energy: R::zero(), max_violation: R::zero() }
    }
}

/// Identifies the kernel of a parameter type, so that the parameters alone determine the force.
pub trait Parameters: Clone {
    /// The kernel with these parameters.
    type Kernel: Kernel<Params = Self>;
}
