// stages: derivative, schedule
/// A body that no row depends on, and a row that depends on nothing.
#[constraint]
pub fn idle(p: Particle, q: Particle, k: Real) -> (Real, Real) {
    (p.position.x, k)
}
