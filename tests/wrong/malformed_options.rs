#[constraint(unilateral per_row)]
pub fn floor(a: Particle) -> Real {
    a.position.z
}
