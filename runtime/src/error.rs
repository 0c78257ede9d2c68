//! What can be wrong with a body, a force or a step.

use thiserror::Error;

/// Why a world refused something; it is unchanged then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Error {
    /// The body or force was removed, or belongs to another world.
    #[error("unknown handle")]
    UnknownHandle,
    /// A force was given too few or too many bodies, or one of the wrong type.
    #[error("force `{0}` does not act on bodies of these types")]
    WrongBodies(&'static str),
    /// NaN or infinity where a number is needed.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// A mass or a principal moment of inertia of zero or less.
    #[error("mass and inertia must be positive")]
    NotPositive,
    /// A quaternion too short to be normalised.
    #[error("orientation has no length")]
    NoOrientation,
    /// Time runs forward.
    #[error("negative step")]
    NegativeStep,
    /// A force between bodies none of which forces move.
    #[error("force `{0}` moves none of its bodies")]
    NothingMoves(&'static str),
    /// A saved world has a force whose kernel was not given, or whose parameters or bodies do not fit it.
    #[error("a saved force has no kernel it fits")]
    UnknownKernel,
    /// What was saved does not hold together.
    #[error("the saved world is damaged")]
    Damaged,
    /// Two shapes met whose contact is not known, two height fields for example.
    #[cfg(feature = "collision")]
    #[error("no contact is known for two shapes that met")]
    NoContact,
}
