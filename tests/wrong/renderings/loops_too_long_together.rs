#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for _ in 0..100_000 {
        for _ in 0..100_000 {
            sum += k;
        }
    }
    sum * a.position.dot(&b.position)
}
