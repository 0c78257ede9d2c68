//! The logarithm of a volume: its second derivative holds 1/det², which leaves the range of floats at edges of 1e-7.

/// E = ln(w det(e1, e2, e3))
///
/// `w`: one over the volume at rest, 1/m³.
#[energy]
#[domain(w = 0.1..10.0)]
pub fn log_volume(p0: Particle, p1: Particle, p2: Particle, p3: Particle, w: Real) -> Real {
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let e3 = p3.position - p0.position;
    (w * e1.dot(&e2.cross(&e3))).ln()
}
