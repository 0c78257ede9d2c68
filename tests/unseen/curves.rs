//! Beads on curves and in bowls.
//!
//! Tried here: a kernel that reads one body only through its absolute position; rows of three kinds in
//! one tuple.

use forcec_runtime::prelude::*;

/// Bead on a helix about z.
#[constraint(per_row)]
#[domain(radius = 0.5..1.0, pitch = 0.2..1.0)]
pub fn bead_on_helix(bead: Particle, radius: Real, pitch: Real) -> Vec2 {
    let (sin, cos) = (2.0 * PI * bead.position.z / pitch).sin_cos();
    Vec2::new(bead.position.x - radius * cos, bead.position.y - radius * sin)
}

/// Bead on a ring torus carried by a body.
#[constraint]
#[domain(large = 1.0..2.0, small = 0.1..0.5)]
pub fn bead_on_torus(bead: Particle, ring: Rigid, large: Real, small: Real) -> Real {
    let seen = ring.orientation.inverse() * (bead.position - ring.position);
    let out = seen.x.hypot(seen.y) - large;
    out.hypot(seen.z) - small
}

/// Marble that may not leave a cone, nor fall below a chain hung across it.
#[constraint(unilateral)]
#[domain(half_angle = 0.2..1.2, sag = 0.3..1.0)]
#[allow(uncovered, reason = "the clamp only guards a cosine")]
pub fn marble_in_cone(marble: Particle, half_angle: Real, sag: Real) -> (Real, Vec2, Real) {
    let x = marble.position;
    let up = x.z / x.norm();
    let swing = up.clamp(-1.0, 1.0).acos();
    let rise = (x.y / x.norm()).asin();
    let floor = Vec2::new(x.z - sag * ((x.x / sag).cosh() - 1.0), x.z * half_angle.tan() - x.y);
    (half_angle - swing, floor, 1.2 - rise.abs())
}

/// Washboard: a bead in an uneven trough, hard to climb out of.
#[energy]
#[domain(depth = 0.5..2.0, waves = 1.0..3.0)]
pub fn washboard(bead: Particle, depth: Real, waves: Vec3) -> Real {
    let phase = bead.position.component_mul(&waves);
    let bowl = (1.0 + bead.position.norm_squared()).ln() + bead.position.x.abs().ln_1p();
    depth * (bowl + phase.x.sin() * phase.y.cos() + 0.1 * phase.z.tanh() + 0.01 * (0.3 * phase.z).sinh())
}
