#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let w = Wrench { force: b.position - a.position };
    k * w.force.norm_squared()
}
