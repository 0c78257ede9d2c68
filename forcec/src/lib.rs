//! forcec, an offline force compiler.
//!
//! A constraint, an energy or a force between bodies, written as one small function in a subset of Rust, becomes C and
//! Rust kernels for the force and its exact derivatives ∂F/∂X and ∂F/∂V.

pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compile;
pub mod derive;
pub mod driver;
pub mod emit;
pub mod kernel;
pub mod layout;
#[cfg(feature = "cli")]
pub mod lint;
pub mod lower;
#[cfg(feature = "expand")]
pub mod macros;
pub mod math;
pub mod model;
pub mod names;
pub mod optimize;
pub mod options;
pub mod rounding;
pub mod sample;
pub mod scalar;
pub mod schedule;
pub mod show;
pub mod source;
pub mod syntax;
pub mod vector;
#[cfg(feature = "verify")]
pub mod verify;

pub use driver::build::Build;
pub use driver::library::{Compiled, Options, compile};
pub use layout::Layout;
pub use math::number::Precision;
pub use model::outputs::Part;
pub use names::Target;
pub use options::Request;
pub use options::plan::{Effort, Mode, Plan};
pub use options::specialize::Specialization;
