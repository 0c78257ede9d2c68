//! Where a value, or a derivative, may not exist: what every value can be, and the places that divide by zero there.

pub(crate) mod ranges;
pub(crate) mod risks;
