#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let square = |x: Real| x * x;
    k * a.position.dot(&b.position)
}
