//! forcec, an offline force compiler.
//!
//! A constraint, an energy or a force between bodies, written as one small function in a subset of Rust, becomes C and
//! Rust kernels for the force F and its exact derivatives ∂F/∂X and ∂F/∂V.
//!
//! ```text
//! force file ─ syntax ─ check ─▶ vector graph ─ derive ─ lower ─▶ scalar graph ─ optimize ─ schedule ─ emit ─▶ C, Rust
//! ```
//!
//! A force file:
//!
//! ```text
//! /// Spring: two particles stay `rest_length` apart.
//! ///
//! /// `rest_length`: m.
//! #[constraint]
//! pub fn spring(p0: Particle, p1: Particle, rest_length: Real) -> Real {
//!     (p1.position - p0.position).norm() - rest_length
//! }
//! ```
//!
//! There are four ways to compile one:
//!
//! - the command line, `forcec build springs.rs --out kernels`;
//! - [`Build`] in a build script, which writes Rust modules that the crate includes;
//! - the attribute macros of `forcec-runtime`, which add a kernel next to the function;
//! - [`compile`], from text to text:
//!
//! ```
//! let text = "#[energy]\npub fn well(p: Particle, k: Real) -> Real { 0.5 * k * p.position.norm_squared() }";
//! let compiled = forcec::compile(text, &forcec::Options::default())?;
//! assert!(compiled.kernel("well").contains("void well_f64("));
//! # Ok::<(), forcec::Diagnostics>(())
//! ```
//!
//! [`Options`] and [`Build`] share their choices: [`Target`], [`Precision`], [`Effort`], [`Mode`], [`Part`] (which outputs)
//! and [`Layout`] (where the outputs are stored). Errors are values that print as a compiler's messages do:
//! [`Diagnostics`], or [`BuildError`] for files.

#![cfg_attr(
    not(all(feature = "cli", feature = "expand")),
    allow(dead_code, unused_imports, reason = "a part of the features does not use everything")
)]

mod check;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod compile;
mod derive;
mod driver;
mod emit;
mod kernel;
mod layout;
#[cfg(feature = "cli")]
mod lint;
mod lower;
#[cfg(feature = "expand")]
#[doc(hidden)]
pub mod macros;
mod math;
mod model;
mod names;
mod optimize;
mod options;
mod rounding;
mod sample;
mod scalar;
mod schedule;
mod show;
mod source;
mod syntax;
mod vector;
#[cfg(feature = "verify")]
mod verify;

pub use driver::build::Build;
pub use driver::files::BuildError;
pub use driver::library::{Compiled, Options, compile};
pub use layout::Layout;
pub use math::number::Precision;
pub use model::outputs::Part;
pub use names::Target;
pub use options::Request;
pub use options::plan::{Effort, Mode, Plan};
pub use options::specialize::Specialization;
pub use source::diagnostic::{Diagnostic, Diagnostics};

/// The stages, for the tests and benchmarks of this project. They change without notice.
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals {
    pub mod check {
        pub use crate::check::*;
    }
    pub mod compile {
        pub use crate::compile::*;
    }
    pub mod derive {
        pub use crate::derive::*;
    }
    pub mod driver {
        pub use crate::driver::*;
    }
    pub mod emit {
        pub use crate::emit::*;
    }
    pub mod kernel {
        pub use crate::kernel::*;
    }
    pub mod layout {
        pub use crate::layout::*;
    }
    #[cfg(feature = "cli")]
    pub mod lint {
        pub use crate::lint::*;
    }
    pub mod lower {
        pub use crate::lower::*;
    }
    pub mod math {
        pub use crate::math::*;
    }
    pub mod model {
        pub use crate::model::*;
    }
    pub mod names {
        pub use crate::names::*;
    }
    pub mod optimize {
        pub use crate::optimize::*;
    }
    pub mod options {
        pub use crate::options::*;
    }
    pub mod rounding {
        pub use crate::rounding::*;
    }
    pub mod sample {
        pub use crate::sample::*;
    }
    pub mod scalar {
        pub use crate::scalar::*;
    }
    pub mod schedule {
        pub use crate::schedule::*;
    }
    pub mod show {
        pub use crate::show::*;
    }
    pub mod source {
        pub use crate::source::*;
    }
    pub mod syntax {
        pub use crate::syntax::*;
    }
    pub mod vector {
        pub use crate::vector::*;
    }
    #[cfg(feature = "verify")]
    pub mod verify {
        pub use crate::verify::*;
    }
}
