//! The arguments and the outputs of a kernel.

pub mod bodies;
pub mod outputs;
