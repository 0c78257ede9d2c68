// stages: c, rust
// layout: product, 1
/// A damped spring: the distance of two particles is `rest_length`.
#[constraint]
fn spring(p: Particle, q: Particle, rest_length: Real) -> Real {
    (q.position - p.position).norm() - rest_length
}
