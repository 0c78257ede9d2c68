#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let w = Wrench { force: b.position, moment: a.position };
    k * w.force.x
}
