// stages: derivative, optimized, schedule, c
#[energy]
pub fn well(p: Particle, k: Real) -> Real {
    0.5 * k * p.position.norm_squared()
}
