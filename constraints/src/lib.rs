//! The library of force files, as functions and as kernels.
//!
//! Each module is a force file of this folder: the text that the command line reads too. A force function is an ordinary
//! function. Its kernel is a module of the same name; the module with the suffix `_f32` is the kernel in single precision.
//!
//! ```
//! use forcec_constraints::springs::spring;
//! use forcec_runtime::prelude::*;
//!
//! let p0 = Particle::default();
//! let p1 = Particle { position: Vec3::x() * 3.0, ..Particle::default() };
//! let params = spring::Params { rest_length: 1.0, stiffness: 10.0, damping: 0.0 };
//! let mut out = spring::Output::default();
//! spring::evaluate(&p0, &p1, &params, &mut out);
//!
//! assert_eq!(spring(p0, p1, 1.0), 2.0);
//! assert_eq!(out.force, [20.0, 0.0, 0.0, -20.0, 0.0, 0.0]);
//! ```

use forcec_runtime::include_forces;

include_forces!("../cloth.rs");
include_forces!("../contacts.rs");
include_forces!("../control.rs");
include_forces!("../fields.rs");
include_forces!("../joints.rs");
include_forces!("../solids.rs");
include_forces!("../springs.rs");

/// The examples of the document about the runtime, which needs forces of this library.
#[cfg(doctest)]
#[doc = include_str!("../../docs/runtime.md")]
struct Runtime;

/// The example of the document about Rust programs.
#[cfg(doctest)]
#[doc = include_str!("../../docs/rust.md")]
struct Rust;
