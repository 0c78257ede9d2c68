//! Numbers and functions of reals: exact fractions, the traits of number types, and the function table.

pub mod exact;
pub mod functions;
pub mod number;
pub mod special;
