#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in 0..3 {
        if i == 2 { break; }
        sum += a.position[i] * b.position[i];
    }
    k * sum
}
