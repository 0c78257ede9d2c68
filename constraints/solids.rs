//! Elastic solids: tetrahedra of four particles.
//!
//! A tetrahedron knows its rest shape by `inverse_rest`, the inverse of the matrix whose columns are its
//! three edges from p0, to p1, p2 and p3, at rest, and by its rest volume. The energies are written in the
//! columns f0, f1, f2 of the deformation gradient F, which are sums of the edges: the entries of FᵀF are
//! their dot products, and det F = f0·(f1 × f2). `mu`, `lambda` are Lamé's parameters; of Young's modulus Y
//! and Poisson's ratio ν
//!
//! ```text
//! μ = Y / (2 (1 + ν)),    λ = Y ν / ((1 + ν)(1 − 2ν)).
//! ```

use forcec_runtime::prelude::*;

/// Neo-Hookean solid: it resists collapse without limit, and must not be inverted.
///
/// E = volume · (μ/2 (tr FᵀF − 3) − μ ln J + λ/2 ln²J), J = det F. Bonet and Wood, "Nonlinear continuum
/// mechanics for finite element analysis", 1997.
///
/// `inverse_rest`: of the edges at rest, 1/m. `volume`: of the rest shape, m³. `mu`, `lambda`: Pa.
#[energy]
#[domain(volume = 1e-4..1.0, mu = 1e3..1e6, lambda = 1e3..1e7)]
pub fn neo_hookean(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    inverse_rest: Mat3,
    volume: Real,
    mu: Real,
    lambda: Real,
) -> Real {
    let (f0, f1, f2) = deformation(p0, p1, p2, p3, inverse_rest);
    let stretch = f0.norm_squared() + f1.norm_squared() + f2.norm_squared();
    let log_j = f0.dot(&f1.cross(&f2)).ln();
    volume * (0.5 * mu * (stretch - 3.0) - mu * log_j + 0.5 * lambda * log_j * log_j)
}

/// Neo-Hookean solid that stays finite when flat or inverted, and recovers.
///
/// E = volume · (μ'/2 (I − 3) + λ'/2 (J − α)² − μ'/2 ln(I + 1)) up to a constant, I = tr FᵀF, J = det F,
/// α = 1 + 3μ'/(4λ'), with μ' = 4/3 μ and λ' = λ + 5/6 μ so that small strains agree with Lamé's parameters.
/// Smith, de Goes, Kim, "Stable neo-Hookean flesh simulation", 2018. The square is multiplied out here, which
/// leaves no quotient by λ'. ln_1p keeps the digits of an element that is crushed to a point.
///
/// `inverse_rest`: of the edges at rest, 1/m. `volume`: of the rest shape, m³. `mu`, `lambda`: Pa.
#[energy]
#[domain(volume = 1e-4..1.0, mu = 1e3..1e6, lambda = 1e3..1e7)]
pub fn stable_neo_hookean(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    inverse_rest: Mat3,
    volume: Real,
    mu: Real,
    lambda: Real,
) -> Real {
    let (f0, f1, f2) = deformation(p0, p1, p2, p3, inverse_rest);
    let stretch = f0.norm_squared() + f1.norm_squared() + f2.norm_squared();
    let growth = f0.dot(&f1.cross(&f2)) - 1.0;
    let shear = 4.0 / 3.0 * mu;
    let bulk = lambda + 5.0 / 6.0 * mu;
    let shape = 0.5 * shear * (stretch - stretch.ln_1p());
    volume * (shape - 0.75 * shear * growth + 0.5 * bulk * growth * growth)
}

/// St. Venant–Kirchhoff solid, linear in Green's strain: cheap, right for small strains, weak in compression.
///
/// E = volume · (μ |G|² + λ/2 (tr G)²), G = ½ (FᵀF − I).
///
/// `inverse_rest`: of the edges at rest, 1/m. `volume`: of the rest shape, m³. `mu`, `lambda`: Pa.
#[energy]
#[domain(volume = 1e-4..1.0, mu = 1e3..1e6, lambda = 1e3..1e7)]
pub fn saint_venant_kirchhoff(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    inverse_rest: Mat3,
    volume: Real,
    mu: Real,
    lambda: Real,
) -> Real {
    let (f0, f1, f2) = deformation(p0, p1, p2, p3, inverse_rest);
    let g00 = 0.5 * (f0.norm_squared() - 1.0);
    let g11 = 0.5 * (f1.norm_squared() - 1.0);
    let g22 = 0.5 * (f2.norm_squared() - 1.0);
    let g01 = 0.5 * f0.dot(&f1);
    let g12 = 0.5 * f1.dot(&f2);
    let g20 = 0.5 * f2.dot(&f0);
    let square = g00 * g00 + g11 * g11 + g22 * g22 + 2.0 * (g01 * g01 + g12 * g12 + g20 * g20);
    let trace = g00 + g11 + g22;
    volume * (mu * square + 0.5 * lambda * trace * trace)
}

/// Fibres within a solid, of a muscle or a tendon: they resist stretch along one direction.
///
/// E = volume · modulus/2 · (|F·direction| − 1)².
///
/// `inverse_rest`: of the edges at rest, 1/m. `volume`: of the rest shape, m³. `direction`: of the fibres at
/// rest. `modulus`: Pa.
#[energy]
#[domain(volume = 1e-4..1.0, direction = unit, modulus = 1e3..1e6)]
pub fn fibers(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    inverse_rest: Mat3,
    volume: Real,
    direction: Vec3,
    modulus: Real,
) -> Real {
    let weights = inverse_rest * direction;
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let e3 = p3.position - p0.position;
    let strain = (e1 * weights.x + e2 * weights.y + e3 * weights.z).norm() - 1.0;
    0.5 * volume * modulus * strain * strain
}

/// Volume of a tetrahedron: it keeps that of its rest shape.
///
/// C = (x1 − x0)·((x2 − x0) × (x3 − x0)) / 6 − rest_volume. Teschner, Heidelberger, Müller, Gross, "A
/// versatile and robust model for geometrically complex deformable solids", 2004.
///
/// `rest_volume`: m³, positive when p1, p2, p3 turn counterclockwise seen from the side away from p0.
#[constraint]
#[domain(rest_volume = 1e-4..1.0)]
pub fn volume(p0: Particle, p1: Particle, p2: Particle, p3: Particle, rest_volume: Real) -> Real {
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let e3 = p3.position - p0.position;
    e1.dot(&e2.cross(&e3)) / 6.0 - rest_volume
}

/// The columns of the deformation gradient F = (x1 − x0, x2 − x0, x3 − x0) · inverse_rest.
fn deformation(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    inverse_rest: Mat3,
) -> (Vec3, Vec3, Vec3) {
    let e1 = p1.position - p0.position;
    let e2 = p2.position - p0.position;
    let e3 = p3.position - p0.position;
    let f0 = e1 * inverse_rest[(0, 0)] + e2 * inverse_rest[(1, 0)] + e3 * inverse_rest[(2, 0)];
    let f1 = e1 * inverse_rest[(0, 1)] + e2 * inverse_rest[(1, 1)] + e3 * inverse_rest[(2, 1)];
    let f2 = e1 * inverse_rest[(0, 2)] + e2 * inverse_rest[(1, 2)] + e3 * inverse_rest[(2, 2)];
    (f0, f1, f2)
}
