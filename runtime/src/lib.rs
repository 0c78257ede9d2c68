//! The run-time library of force functions and their kernels.
//!
//! Force functions use the types of the [`prelude`]. With the default feature `macros`, an attribute compiles
//! a force function to a kernel at compile time:
//!
//! ```
//! use forcec_runtime::prelude::*;
//!
//! /// Ball joint: the anchor on `a` meets the anchor on `b`.
//! #[constraint]
//! pub fn ball(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
//!     let pa = a.position + a.orientation * arm_a;
//!     let pb = b.position + b.orientation * arm_b;
//!     pb - pa
//! }
//!
//! // The function is still callable,
//! let a = Rigid::default();
//! let b = Rigid { position: Vec3::new(0.0, 0.0, 1.5), ..Rigid::default() };
//! assert_eq!(ball(a, b, Vec3::z(), -Vec3::z()).z, -0.5);
//!
//! // and its kernel is the module `ball`.
//! let params =
//!     ball::Params { arm_a: [0.0, 0.0, 1.0], arm_b: [0.0, 0.0, -1.0], stiffness: 100.0, damping: 0.0 };
//! let mut out = ball::Output::default();
//! ball::evaluate(&a, &b, &params, &mut out);
//! assert_eq!(out.force[2], -50.0);
//! ```
//!
//! Without default features this crate has no macros and does not depend on the compiler; kernels then come
//! from `forcec build --target rust` or from a build script.

// Generated code refers to this crate by name, also for the contact kernel inside this crate.
#[cfg(feature = "collision")]
extern crate self as forcec_runtime;

#[cfg(feature = "collision")]
pub mod collision;
pub mod error;
mod island;
pub mod kernel;
mod outside;
pub mod prelude;
pub mod prelude_f32;
mod report;
mod settings;
mod state;
mod step;
mod system;
pub mod world;

pub use error::Error;
#[cfg(feature = "macros")]
pub use forcec_macros::{constraint, domain, energy, force, forces, include_forces};
pub use kernel::bodies::{Particle, ParticleF32, ParticleLanes, Rigid, RigidF32, RigidLanes, Wrench};
pub use kernel::{Bodies, BodiesLanes, BodyKind, Kernel, Linear, Measure, Numbers, Parameters, Rows, Saddle};
pub use kernel::{bodies, functions};
pub use nalgebra;
pub use report::Report;
pub use settings::{Decoupling, Settings, Sleep};
pub use state::{Body, Motion};
pub use step::Integrator;
pub use system::iterative::Solver;
#[cfg(feature = "serde")]
pub use world::save::{Kernels, Saved};
pub use world::{Force, Law, World, Worlds};
