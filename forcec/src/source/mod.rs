//! Places in a text, and what is said about them.

pub mod diagnostic;
pub mod span;
pub(crate) mod suggest;
