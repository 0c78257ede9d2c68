//! What ties a kernel to the runtime: a trait that the macros implement beside the kernel's module.
//!
//! A kernel is named by its `Output`, which every kernel has. Whoever holds bodies in arrays evaluates it in place: the
//! bodies of one force are given by their indices, and nothing is packed or copied.

use crate::bodies::{Particle, Rigid};
use nalgebra::RealField;

/// A body type.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyKind {
    /// [`Rigid`], six degrees of freedom: position, then rotation.
    Rigid,
    /// [`Particle`], three degrees of freedom.
    Particle,
}

impl BodyKind {
    /// Degrees of freedom.
    pub const fn freedoms(self) -> usize {
        match self {
            BodyKind::Rigid => 6,
            BodyKind::Particle => 3,
        }
    }
}

/// A list of numbers: parameters are written to one. Kernels name it so that a crate without the standard library can have
/// them.
pub type Numbers<R> = Vec<R>;

/// Bodies, an array for each type.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a, R: RealField> {
    /// Rigid bodies.
    pub rigid: &'a [Rigid<R>],
    /// Particles.
    pub particles: &'a [Particle<R>],
}

/// A kernel: a force and its derivatives as a function of bodies and parameters.
pub trait Kernel: Clone + Default + Send + 'static {
    /// The precision it computes in.
    type Real: RealField + Copy;
    /// Its parameters; `()` if it has none.
    type Params: Clone + Send + 'static;
    /// An index for each body, `[usize; n]`.
    type Indices: Copy + Default + AsRef<[usize]> + AsMut<[usize]> + Send + 'static;
    /// The name of its force function.
    const NAME: &'static str;
    /// The types of its bodies, in argument order.
    const BODIES: &'static [BodyKind];
    /// Degrees of freedom of all its bodies: N.
    const FREEDOMS: usize;
    /// For each row of ∂F/∂X a string of N letters: `.` stands where the entry is always zero.
    const DFDX_NONZERO: &'static [&'static str];
    /// The same for ∂F/∂V.
    const DFDV_NONZERO: &'static [&'static str];

    /// Computes force and derivatives for the bodies at these indices, each an index into the array of its type.
    ///
    /// Panics if an index is out of range.
    fn evaluate(&mut self, bodies: &Bodies<'_, Self::Real>, indices: Self::Indices, params: &Self::Params);

    /// F: N entries, the bodies in argument order.
    fn force(&self) -> &[Self::Real];

    /// ∂F/∂X: N² entries, row by row.
    fn dfdx(&self) -> &[Self::Real];

    /// ∂F/∂V: N² entries, row by row.
    fn dfdv(&self) -> &[Self::Real];

    /// Where [`Kernel::evaluate_force`] writes.
    type Force: Clone + Default + Send + 'static;

    /// Computes F alone, in less time: N entries.
    fn evaluate_force<'a>(
        out: &'a mut Self::Force,
        bodies: &Bodies<'_, Self::Real>,
        indices: Self::Indices,
        params: &Self::Params,
    ) -> &'a [Self::Real];

    /// Where [`Kernel::evaluate_step`] writes.
    type Step: Clone + Default + Send + 'static;

    /// How many rows C has, each with a multiplier λ = stiffness C + damping Ċ; an energy and a force have none.
    const ROWS: usize = 0;
    /// Whether λ is zero where it would be positive.
    const ONE_SIDED: bool = false;

    /// Computes what a step of h s takes, in less time than both derivatives. `multipliers` stand for λ where gradients of C
    /// turn, so that a pose at which joints are stretched does no harm to the matrix; there are [`Kernel::ROWS`] of them.
    ///
    /// Panics if there are fewer, or if an index is out of range.
    fn evaluate_step<'a>(
        out: &'a mut Self::Step,
        bodies: &Bodies<'_, Self::Real>,
        indices: Self::Indices,
        params: &Self::Params,
        step: Self::Real,
        multipliers: &[Self::Real],
    ) -> Linear<'a, Self::Real>;

    /// Whether it has a potential that [`Kernel::measure`] knows: constraints and energies do.
    const HAS_POTENTIAL: bool = false;

    /// The potential energy and the gap for the bodies at these indices.
    fn measure(
        _bodies: &Bodies<'_, Self::Real>,
        _indices: Self::Indices,
        _params: &Self::Params,
    ) -> Measure<Self::Real> {
        Measure::default()
    }

    /// Appends the parameters as numbers, in source order.
    fn write_params(params: &Self::Params, numbers: &mut Vec<Self::Real>);

    /// The parameters that `write_params` wrote; none if there are too few numbers.
    fn read_params(numbers: &mut dyn Iterator<Item = Self::Real>) -> Option<Self::Params>;
}

/// A force about a state, as a step of h s takes it.
#[derive(Clone, Copy, Debug)]
pub struct Linear<'a, R> {
    /// F: N entries.
    pub force: &'a [R],
    /// h ∂F/∂V + h² ∂F/∂X, given multipliers in place of λ where gradients of C turn: N² entries, row by row.
    pub matrix: &'a [R],
    /// λ, an entry a row of C.
    pub multipliers: &'a [R],
    /// h ∂λ/∂V + h² ∂λ/∂X: N entries a row of C.
    pub slopes: &'a [R],
}

/// What a constraint or an energy stores, and how far it is from home.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measure<R> {
    /// Potential energy: ½ stiffness C², each row by its own, or E.
    pub energy: R,
    /// The largest |C| of the rows; of a unilateral constraint only those count that push. Zero for an energy.
    pub gap: R,
}

impl<R: RealField> Default for Measure<R> {
    fn default() -> Measure<R> {
        Measure { energy: R::zero(), gap: R::zero() }
    }
}

/// The parameters of a kernel know it: a force can be named by its parameters alone.
pub trait Parameters: Clone {
    /// The kernel these are the parameters of.
    type Kernel: Kernel<Params = Self>;
}
