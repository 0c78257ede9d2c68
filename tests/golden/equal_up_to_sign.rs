// stages: derivative, schedule, c
/// Every block is the same one or its negative.
#[constraint]
pub fn rod(p: Particle, q: Particle, length: Real) -> Real {
    (q.position - p.position).norm() - length
}
