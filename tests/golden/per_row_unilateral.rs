// stages: ast, derivative, schedule
#[constraint(per_row, unilateral)]
pub fn slab(p: Particle, lower: Real, upper: Real) -> (Real, Real) {
    (p.position.x - lower, upper - p.position.x)
}
