// stages: graph, schedule, c
/// Far from the origin positions are subtracted before anything is added.
#[force]
pub fn gap(a: Particle, b: Particle, k: Real, offset: Vec3) -> (Vec3, Vec3) {
    let force = k * (b.position - a.position + offset);
    (force, -force)
}
