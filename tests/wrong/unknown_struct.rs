#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let w = Wrensh { force: b.position, torque: a.position };
    k * w.force.x
}
