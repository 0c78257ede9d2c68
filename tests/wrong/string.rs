#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let s = "k";
    k * a.position.dot(&b.position)
}
