// stages: header, c, rust
// layout: packed, 4
/// A rope of two particles: it pulls only where it is longer than `length`.
#[constraint(unilateral)]
fn rope(p: Particle, q: Particle, length: Real) -> Real {
    length - (q.position - p.position).norm()
}
