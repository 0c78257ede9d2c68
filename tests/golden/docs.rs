// stages: header, c, rust
//! The file, with a trap: */ and /* and \ at the end \
//!
//! Its second paragraph.

/// One line of `code` and *stars* */ more.
///
/// - a list
/// - of two
#[force]
pub fn documented(p: Particle) -> Vec3 {
    p.velocity
}
