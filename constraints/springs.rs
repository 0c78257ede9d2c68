//! Springs between particles.
//!
//! A constraint |d| − L is a linear spring with a damper along it; a spring of any other law is an energy.

use forcec_runtime::prelude::*;

/// Spring with damper: two particles stay `rest_length` apart.
///
/// C = |x1 − x0| − rest_length.
///
/// `rest_length`: m.
#[constraint]
#[domain(rest_length = 0.1..2.0)]
pub fn spring(p0: Particle, p1: Particle, rest_length: Real) -> Real {
    (p1.position - p0.position).norm() - rest_length
}

/// Spring without a square root: it measures the squared length, as Green's strain does.
///
/// C = (|x1 − x0|² − rest_length²) / (2 rest_length). It agrees with `spring` to first order about the rest
/// length, stiffens in tension, and is smooth even where the particles meet.
///
/// `rest_length`: m.
#[constraint]
#[domain(rest_length = 0.1..2.0)]
pub fn green_spring(p0: Particle, p1: Particle, rest_length: Real) -> Real {
    let edge = p1.position - p0.position;
    (edge.norm_squared() - rest_length * rest_length) / (2.0 * rest_length)
}

/// Spring whose stiffness is a polynomial in the stretch.
///
/// With s = |x1 − x0| − rest_length the stiffness is Σ cₖ sᵏ, the tension its integral, and the energy
/// E = Σ cₖ sᵏ⁺² / ((k + 1)(k + 2)).
///
/// `rest_length`: m. `coefficients`: cₖ, N/mᵏ⁺¹, lowest power first.
#[energy]
#[domain(rest_length = 0.1..2.0, coefficients = 0.0..1e4)]
pub fn polynomial_spring(p0: Particle, p1: Particle, rest_length: Real, coefficients: [Real; 4]) -> Real {
    let stretch = (p1.position - p0.position).norm() - rest_length;
    let mut power = stretch * stretch;
    let mut energy = 0.0;
    for k in 0..4 {
        let order = k as Real;
        energy += coefficients[k] * power / ((order + 1.0) * (order + 2.0));
        power *= stretch;
    }
    energy
}

/// Spring of soft tissue, which stiffens exponentially.
///
/// E = stiffness · L² / (2 β) · (exp(β e²) − 1), with the strain e = |x1 − x0| / L − 1. Fung, "Elasticity of
/// soft tissues in simple elongation", 1967.
///
/// `rest_length`: L, m. `stiffness`: at rest, N/m. `exponent`: β.
#[energy]
#[domain(rest_length = 0.1..2.0, stiffness = 1.0..1e4, exponent = 0.5..20.0)]
pub fn tissue_spring(p0: Particle, p1: Particle, rest_length: Real, stiffness: Real, exponent: Real) -> Real {
    let stretch = (p1.position - p0.position).norm() - rest_length;
    let strain = stretch / rest_length;
    let scale = stiffness * rest_length * rest_length / (2.0 * exponent);
    scale * (exponent * strain * strain).exp_m1()
}

/// Rope: two particles are never further apart than its length.
///
/// C = length − |x1 − x0|, pulling only while it is negative.
///
/// `length`: m.
#[constraint(unilateral)]
#[domain(length = 0.1..2.0)]
pub fn rope(p0: Particle, p1: Particle, length: Real) -> Real {
    length - (p1.position - p0.position).norm()
}

/// Bending of a rod or hair: the middle particle stays halfway between its neighbours, but for `rest`.
///
/// C = (x2 − x1) − (x1 − x0) − rest: linear, so its derivatives are constant.
///
/// `rest`: the same difference in the rest shape, zero for a straight rod with equal edges, m. It does not
/// turn with the rod.
#[constraint]
pub fn rod_bend(p0: Particle, p1: Particle, p2: Particle, rest: Vec3) -> Vec3 {
    let first = p1.position - p0.position;
    let second = p2.position - p1.position;
    second - first - rest
}
