#[energy]
pub fn f(mut p: Particle, mut k: Real) -> Real {
    k = 2.0;
    p.position.x = 3.0;
    p.position.x * k
}
