#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    println!("{}", k);
    k * a.position.dot(&b.position)
}
