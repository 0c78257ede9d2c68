#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut x = k;
    while x > 1.0 {
        x *= 0.5;
    }
    x * a.position.dot(&b.position)
}
