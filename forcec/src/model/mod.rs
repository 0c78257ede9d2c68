//! What a kernel takes and computes: bodies and parameters, and the outputs.

pub mod bodies;
pub mod outputs;
