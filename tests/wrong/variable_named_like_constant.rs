const K: Real = 3.0;

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let K = 2.0;
    K * k * a.position.dot(&b.position)
}
