//! States to examine a function at: how they are drawn, and where each input is among their numbers.

pub mod inputs;
pub mod states;
