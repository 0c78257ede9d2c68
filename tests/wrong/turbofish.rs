#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * a.position.dot::<Real>(&b.position)
}
