//! Source texts, positions in them, and diagnostics.

pub mod diagnostic;
pub mod span;
pub(crate) mod suggest;
