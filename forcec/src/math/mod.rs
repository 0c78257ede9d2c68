//! Numbers and functions of reals: exact fractions, the traits of number types, the function table, and
//! random numbers.

pub mod exact;
pub mod functions;
pub mod number;
pub mod random;
pub mod special;
