//! Values and derivatives that may not exist: ranges of all values, and expressions that can be singular.

pub(crate) mod ranges;
pub(crate) mod risks;
