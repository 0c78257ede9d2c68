//! Cloth: triangles and pairs of triangles of particles.
//!
//! A triangle knows its rest shape by `inverse_rest`, the inverse of the 2×2 matrix whose columns are its two
//! edges from p0, to p1 and to p2, in coordinates u, v of the fabric, m. The columns of the deformation
//! gradient, wu = ∂x/∂u and wv = ∂x/∂v, are then sums of the edges. A pair of triangles has the edge p0 p1 in
//! common, p2 on one side and p3 on the other.

use forcec_runtime::prelude::*;

/// Stretch of a triangle along the two directions of the fabric.
///
/// C = area · (|wu| − 1, |wv| − 1). Baraff and Witkin, "Large steps in cloth simulation", 1998.
///
/// `inverse_rest`: of the triangle's edges in the fabric, 1/m. `area`: of the rest shape, m².
#[constraint]
#[domain(area = 1e-3..1.0)]
pub fn cloth_stretch(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    inverse_rest: Mat2,
    area: Real,
) -> (Real, Real) {
    let (wu, wv) = fabric_directions(p0, p1, p2, inverse_rest);
    (area * (wu.norm() - 1.0), area * (wv.norm() - 1.0))
}

/// Shear of a triangle: the two directions of the fabric stay at right angles.
///
/// C = area · wu·wv. Baraff and Witkin, "Large steps in cloth simulation", 1998.
///
/// `inverse_rest`: of the triangle's edges in the fabric, 1/m. `area`: of the rest shape, m².
#[constraint]
#[domain(area = 1e-3..1.0)]
pub fn cloth_shear(p0: Particle, p1: Particle, p2: Particle, inverse_rest: Mat2, area: Real) -> Real {
    let (wu, wv) = fabric_directions(p0, p1, p2, inverse_rest);
    area * wu.dot(&wv)
}

/// Bending of a pair of triangles by the angle between them.
///
/// C = θ − rest_angle, θ as in `dihedral`. Baraff and Witkin, "Large steps in cloth simulation", 1998.
///
/// `rest_angle`: zero for cloth that is flat at rest, rad.
#[constraint]
#[domain(rest_angle = -2.0..2.0)]
pub fn cloth_bend(p0: Particle, p1: Particle, p2: Particle, p3: Particle, rest_angle: Real) -> Real {
    dihedral_angle(p0, p1, p2, p3) - rest_angle
}

/// Bending energy of a pair of triangles.
///
/// E = stiffness/2 · (θ − rest_angle)², θ = atan2(|e| b·n, n·m) with e = x1 − x0, a = x2 − x0, b = x3 − x0,
/// n = e × a, m = b × e: zero when flat, positive when p3 rises on the side of n, −π … π. Nothing is
/// normalised, so it is singular only where a triangle has no area. Grinspun, Hirani, Desbrun, Schröder,
/// "Discrete shells", 2003, with their weight 6 |e|² / (area of both) in the stiffness.
///
/// `stiffness`: N·m/rad². `rest_angle`: rad.
#[energy]
#[domain(stiffness = 1e-4..10.0, rest_angle = -2.0..2.0)]
pub fn dihedral(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    stiffness: Real,
    rest_angle: Real,
) -> Real {
    let turn = dihedral_angle(p0, p1, p2, p3) - rest_angle;
    0.5 * stiffness * turn * turn
}

/// Bending of a pair of triangles that are flat at rest and do not stretch: linear in the positions.
///
/// C = Σ wᵢ xᵢ, the weights w made of cotangents of the rest shape, Σ wᵢ = 0. Bergou, Wardetzky, Harmon,
/// Zorin, Grinspun, "A quadratic bending model for inextensible surfaces", 2006.
///
/// `weights`: of p0, p1, p2, p3; the first is minus the sum of the others and is not read.
#[constraint]
#[domain(weights = -3.0..3.0)]
pub fn isometric_bend(p0: Particle, p1: Particle, p2: Particle, p3: Particle, weights: Vec4) -> Vec3 {
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let e3 = p3.position - p0.position;
    e1 * weights.y + e2 * weights.z + e3 * weights.w
}

/// Membrane energy of a triangle, linear in Green's strain.
///
/// E = area · (μ |G|² + λ/2 (tr G)²), G = ½ (FᵀF − I), F = (wu wv). St. Venant and Kirchhoff.
///
/// `inverse_rest`: of the triangle's edges in the fabric, 1/m. `area`: of the rest shape, m². `mu`, `lambda`:
/// Lamé's parameters times the thickness, N/m.
#[energy]
#[domain(area = 1e-3..1.0, mu = 1.0..1e4, lambda = 1.0..1e4)]
pub fn stvk_triangle(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    inverse_rest: Mat2,
    area: Real,
    mu: Real,
    lambda: Real,
) -> Real {
    let (wu, wv) = fabric_directions(p0, p1, p2, inverse_rest);
    let uu = 0.5 * (wu.norm_squared() - 1.0);
    let vv = 0.5 * (wv.norm_squared() - 1.0);
    let uv = 0.5 * wu.dot(&wv);
    let trace = uu + vv;
    area * (mu * (uu * uu + vv * vv + 2.0 * uv * uv) + 0.5 * lambda * trace * trace)
}

/// The directions wu = ∂x/∂u and wv = ∂x/∂v into which a triangle carries those of the fabric.
fn fabric_directions(p0: Particle, p1: Particle, p2: Particle, inverse_rest: Mat2) -> (Vec3, Vec3) {
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let wu = e1 * inverse_rest[(0, 0)] + e2 * inverse_rest[(1, 0)];
    let wv = e1 * inverse_rest[(0, 1)] + e2 * inverse_rest[(1, 1)];
    (wu, wv)
}

/// The angle by which the pair of triangles is folded along the edge p0 p1.
fn dihedral_angle(p0: Particle, p1: Particle, p2: Particle, p3: Particle) -> Real {
    let edge = p1.position - p0.position;
    let side_a = p2.position - p0.position;
    let side_b = p3.position - p0.position;
    let normal_a = edge.cross(&side_a);
    let normal_b = side_b.cross(&edge);
    (edge.norm() * side_b.dot(&normal_a)).atan2(normal_a.dot(&normal_b))
}
