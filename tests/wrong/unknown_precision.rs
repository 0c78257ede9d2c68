#[constraint(real = f16)]
pub fn floor(a: Particle) -> Real {
    a.position.z
}
