//! forcec, an offline force compiler.
//!
//! A constraint, an energy or a force between bodies, written as one small function in a subset of Rust, becomes C and
//! Rust kernels for the force and its exact derivatives ∂F/∂X and ∂F/∂V.

pub mod bodies;
pub mod build;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compile;
pub mod definition;
pub mod derive;
pub mod diagnostic;
pub mod eval;
pub mod exact;
#[cfg(feature = "expand")]
pub mod expand;
mod files;
pub mod formula;
pub mod identifiers;
pub mod identities;
pub mod kernel;
pub mod layouts;
pub mod library;
#[cfg(feature = "cli")]
pub mod lint;
#[cfg(feature = "expand")]
mod manifest;
pub mod number;
pub mod ops;
pub mod optimize;
pub mod options;
pub mod outputs;
pub mod places;
pub mod plan;
pub mod prepare;
pub mod rounding;
pub mod scalar;
#[cfg(feature = "scenes")]
mod scene;
pub mod schedule;
pub mod span;
pub mod special;
pub mod specialize;
pub mod states;
mod suggest;
pub mod syntax;
pub mod targets;
pub mod text;
#[cfg(feature = "expand")]
mod ties;
pub mod valuation;
pub mod vector;
#[cfg(feature = "verify")]
pub mod verify;

pub use build::Build;
pub use identifiers::Target;
pub use layouts::Layout;
pub use library::{Compiled, Options, compile};
pub use options::Request;
pub use outputs::Part;
pub use plan::{Effort, Mode, Plan, Precision};
pub use specialize::Specialization;
