#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let (x, y) = (k, a.position.x, b.position.x);
    x * y
}
