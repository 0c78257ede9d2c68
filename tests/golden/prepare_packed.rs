// stages: header, c, rust
// layout: packed, 4, prepare
/// Weights: the force is a weighted point's, its weights are computed once.
#[energy]
fn weighted(p: Particle, weights: [Vec3; 3], k: Real) -> Real {
    let sum = weights[0] + weights[1] * 2.0 + weights[2];
    let off = p.position - weights[0];
    0.5 * k * sum.norm_squared() * off.norm_squared()
}
