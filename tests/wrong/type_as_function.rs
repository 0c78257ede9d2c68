#[force]
pub fn wind(p: Particle, speed: Real) -> Vec3 {
    vec3(speed, 0.0, 0.0) - p.velocity
}
