// stages: ast, derivative
#[constraint]
pub fn stops(p: Particle, q: Particle) -> (Real, Vec2, Real) {
    (p.position.x, Vec2::new(p.position.y, q.position.y), q.position.z)
}
