#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    for i in 0..3 {
        a.position[i]
    }
    k * b.position.x
}
