// stages: derivative, schedule, rust
#[force]
pub fn brake(p: Particle, rate: Real) -> Vec3 {
    -rate * p.velocity
}
