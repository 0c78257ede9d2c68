#[cfg(feature = "floor")]
#[constraint]
pub fn floor(a: Particle) -> Real {
    a.position.z
}
