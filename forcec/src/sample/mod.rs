//! States for checking a function: how they are drawn, and the index of each input among their numbers.

pub mod inputs;
pub mod states;
