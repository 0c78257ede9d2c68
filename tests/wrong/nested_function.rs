#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    fn square(x: Real) -> Real { x * x }
    k * square(a.position.dot(&b.position))
}
