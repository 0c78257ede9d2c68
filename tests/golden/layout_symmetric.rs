// stages: header, c, rust
// layout: symmetric, 1
/// Rubber: the energy of a spring between two particles is that of its squared length, and its Hessian symmetric.
#[energy]
fn rubber(p: Particle, q: Particle, rest_length: Real, k: Real) -> Real {
    let strain = (q.position - p.position).norm_squared() / (rest_length * rest_length) - 1.0;
    0.5 * k * strain * strain
}
