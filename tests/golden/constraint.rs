// stages: ast, graph, derivative, optimized, schedule, header, c, rust
//! A penalty force.

/// The height of a particle over the ground.
///
/// `ground`: m.
#[constraint]
pub fn height(p: Particle, ground: Real) -> Real {
    p.position.z - ground
}
