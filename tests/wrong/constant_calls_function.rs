const HALF: Real = half(1.0);

fn half(x: Real) -> Real {
    0.5 * x
}

#[energy]
pub fn well(p: Particle) -> Real {
    half(HALF) * p.position.norm_squared()
}
