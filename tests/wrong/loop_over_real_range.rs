#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in 0..k {
        sum += 1.0;
    }
    sum * a.position.dot(&b.position)
}
