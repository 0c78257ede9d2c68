//! Entry points that read and write files: build scripts, compilation of a text, scenes, and output files.

pub mod build;
pub(crate) mod files;
pub mod library;
#[cfg(feature = "scenes")]
pub(crate) mod scene;
