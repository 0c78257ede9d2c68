//! Numbers and functions of reals: exact fractions, what expressions can be evaluated in, the function table.

pub mod exact;
pub mod functions;
pub mod number;
pub mod special;
