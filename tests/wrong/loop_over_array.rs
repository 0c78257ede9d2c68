#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for x in [1.0, 2.0] {
        sum += x;
    }
    k * sum * a.position.dot(&b.position)
}
