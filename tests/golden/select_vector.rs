// stages: graph, derivative, c
#[force]
pub fn gate(p: Particle, open: Real) -> Vec3 {
    if p.position.x < open { p.velocity } else { Vec3::zeros() }
}
