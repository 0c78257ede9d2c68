const K: Real = 2.0 * L;
const L: Real = 0.5 * K;

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    K * k * a.position.dot(&b.position)
}
