// stages: lower, formulate, collect, extract, resubstitute, search
/// A stretched and sheared edge: something for every pass.
#[energy]
pub fn edge(p: Particle, q: Particle, r: Particle, k: Real, u: Vec3, length: Real) -> Real {
    let d = q.position - p.position;
    let e = r.position - p.position;
    let stretch = d.norm() - length;
    let shear = d.dot(&u) * e.dot(&u) + d.dot(&e);
    0.5 * k * (stretch * stretch + shear * shear)
}
