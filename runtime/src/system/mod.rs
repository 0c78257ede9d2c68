//! From kernels to a linear system: blocks of force and derivatives, their sum over all forces, and its solvers.

pub(crate) mod assemble;
pub(crate) mod batch;
pub(crate) mod block;
pub(crate) mod inertia;
pub(crate) mod iterative;
pub(crate) mod sparse;
