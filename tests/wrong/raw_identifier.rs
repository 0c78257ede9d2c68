#[energy]
pub fn spring(a: Particle, b: Particle, r#type: Real) -> Real {
    r#type * a.position.dot(&b.position)
}
