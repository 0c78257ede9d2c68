#[energy]
pub fn well(a: Particle, b: Particle, k: Real, rest: Real) -> Real {
    let d = b.position - a.position;
    let _length = 1.0;
    k * a.position.x
}
