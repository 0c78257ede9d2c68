#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    let mut i = 0;
    i++;
    k * p.position.x
}
