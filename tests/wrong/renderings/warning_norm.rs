#[constraint]
#[domain(rest = 0.1..2.0)]
pub fn distance(a: Particle, b: Particle, rest: Real) -> Real {
    (b.position - a.position).norm() - rest
}
