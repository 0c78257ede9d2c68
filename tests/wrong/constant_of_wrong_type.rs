const K: Real = 2;

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    K * k * a.position.dot(&b.position)
}
