//! Errors of worlds, bodies, forces and steps.

use thiserror::Error;

/// The reason why a world rejected a call; the world is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// The body or force was removed, or belongs to another world.
    #[error("unknown handle")]
    UnknownHandle,
    /// A force has too few or too many bodies, or a body of the wrong type.
    #[error("force `{0}` does not act on bodies of these types")]
    WrongBodies(&'static str),
    /// A number is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// A mass or a principal moment of inertia is zero or negative.
    #[error("mass and inertia must be positive")]
    NotPositive,
    /// A quaternion is too short to normalise.
    #[error("orientation has no length")]
    NoOrientation,
    /// There are not as many loads or states as copies of a world.
    #[error("one value per copy of the world is needed")]
    WrongCount,
    /// The step is negative.
    #[error("negative step")]
    NegativeStep,
    /// All bodies of a force are kinematic.
    #[error("force `{0}` moves none of its bodies")]
    NothingMoves(&'static str),
    /// A law for constraints was given for an energy, a force, or a constraint with fixed stiffness.
    #[error("force `{0}` is not a constraint with stiffness")]
    NotAConstraint(&'static str),
    /// A one-sided constraint cannot be rigid.
    #[error("force `{0}` is one-sided, so it cannot be rigid")]
    OneSided(&'static str),
    /// The kernel of a saved force is missing, or does not fit the saved parameters or bodies.
    #[error("a saved force has no kernel it fits")]
    UnknownKernel,
    /// A saved world is inconsistent.
    #[error("the saved world is damaged")]
    Damaged,
    /// No contact algorithm exists for two shapes that met, such as two height fields.
    #[cfg(feature = "collision")]
    #[error("no contact is known for two shapes that met")]
    NoContact,
}
