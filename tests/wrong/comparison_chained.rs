#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    if 0.0 < k < 1.0 { 1.0 } else { p.position.x }
}
