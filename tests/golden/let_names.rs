// stages: graph, c
/// Temporaries are named after the source, shadowed names too.
#[energy]
pub fn named(p: Particle, k: Real) -> Real {
    let stretch = (p.position.x * p.position.y + k).sqrt();
    let energy = stretch * stretch * stretch;
    let stretch = energy + k * stretch;
    stretch / (1.0 + energy)
}
