//! From kernels to a linear system: blocks of force and derivatives, their sum over all forces, and its solvers.

pub(crate) mod assemble;
pub(crate) mod batch;
pub(crate) mod block;
pub(crate) mod factor;
pub(crate) mod inertia;
pub(crate) mod iterative;
pub(crate) mod lane_batch;
pub(crate) mod lanes;
pub(crate) mod order;
pub(crate) mod plan;
pub(crate) mod sparse;
