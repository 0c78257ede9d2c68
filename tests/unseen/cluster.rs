//! Atoms.
//!
//! Tried here: an inner range that starts at `i + 1`; `0..=2`; `[Real; ATOMS]`; `if i != j` between loop
//! variables, where the untaken arm divides by zero or indexes past the end; `powi(power)` by a loop
//! variable; bodies in an array.

use forcec_runtime::prelude::*;

const ATOMS: usize = 4;
const CUTOFF: Real = 2.5;

/// The twelve–six well, in units of its depth, of the squared distance in units of the diameter.
fn twelve_six(square: Real) -> Real {
    let sixth = square.powi(-3);
    4.0 * sixth * (sixth - 1.0)
}

/// Lennard-Jones cluster of four with Lorentz–Berthelot mixing, cut off and shifted.
#[energy]
#[domain(depths = 0.5..2.0, sizes = 0.5..1.0)]
pub fn lennard_jones(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    p3: Particle,
    depths: [Real; ATOMS],
    sizes: [Real; 4],
) -> Real {
    let atoms = [p0, p1, p2, p3];
    let shift = twelve_six(CUTOFF * CUTOFF);
    let mut energy = 0.0;
    for i in 0..ATOMS {
        for j in (i + 1)..ATOMS {
            let depth = (depths[i] * depths[j]).sqrt();
            let size = (sizes[i] + sizes[j]) / 2.0;
            let square = (atoms[j].position - atoms[i].position).norm_squared() / (size * size);
            energy += if square < CUTOFF * CUTOFF { depth * (twelve_six(square) - shift) } else { 0.0 };
        }
    }
    energy
}

/// Axilrod–Teller three-body term over Morse bonds; each ordered pair is met twice, a pair with itself never.
#[energy]
#[domain(depth = 0.1..1.0, width = 1.0..3.0, rest = 0.8..1.2, triple = 0.01..0.1)]
pub fn morse_triple(
    a: Particle,
    b: Particle,
    c: Particle,
    depth: Real,
    width: Real,
    rest: Real,
    triple: Real,
) -> Real {
    let x = [a.position, b.position, c.position];
    let mut bonds = 0.0;
    let mut product = 1.0;
    for i in 0..3 {
        for j in 0..3 {
            bonds += if i != j {
                let edge = x[j] - x[i];
                depth * (-width * (edge.norm() - rest)).exp_m1().powi(2) / 2.0
            } else {
                0.0
            };
        }
    }
    for i in 0..=2 {
        let r: Vec3 = if i == 2 { x[0] - x[2] } else { x[i + 1] - x[i] };
        product /= r.norm_squared() * r.norm();
    }
    bonds + triple * product
}

/// Sum of Gaussians and of powers, lowest order first.
#[energy]
#[domain(heights = -1.0..1.0, widths = 0.5..2.0, series = -0.1..0.1)]
pub fn bumps(p: Particle, centres: [Vec3; 3], heights: [Real; 3], widths: [Real; 3], series: Vec4) -> Real {
    let mut energy = 0.0;
    for k in 0..3 {
        let away = (p.position - centres[k]) / widths[k];
        energy += heights[k] * (-0.5 * away.norm_squared()).exp();
    }
    for power in 1..5 {
        energy += p.position.norm_squared().powi(power) / power as Real;
    }
    for k in 0..3 {
        energy -= series[k] * p.position[k] + series[3] * p.position[0] * p.position[k];
    }
    energy
}
