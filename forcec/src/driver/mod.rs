//! Files in, files out: the build-script library, compilation of a text, scenes, and what is written to disk.

pub mod build;
pub(crate) mod files;
pub mod library;
#[cfg(feature = "scenes")]
pub(crate) mod scene;
