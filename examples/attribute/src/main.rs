//! A rubber band: the function is called for its energy, its kernel computes the force.

use forcec_runtime::prelude::*;

/// Rubber band: pulls two particles together, and never pushes them apart.
///
/// `rest_length`: m. `stiffness`: J.
#[energy]
#[domain(rest_length = 0.1..2.0, stiffness = 1.0..1e4)]
pub fn rubber_band(p0: Particle, p1: Particle, rest_length: Real, stiffness: Real) -> Real {
    let band = p1.position - p0.position;
    let strain = 0.5 * (band.norm_squared() / (rest_length * rest_length) - 1.0);
    if strain > 0.0 { 0.5 * stiffness * strain * strain } else { 0.0 }
}

fn main() {
    let p0 = Particle::default();
    let p1 = Particle { position: Vec3::new(1.0, 2.0, 2.0), ..Particle::default() };
    println!("energy {:.1} J", rubber_band(p0, p1, 1.0, 10.0));

    let params = rubber_band::Params { rest_length: 1.0, stiffness: 10.0 };
    let mut out = rubber_band::Output::default();
    rubber_band::evaluate(&p0, &p1, &params, &mut out);
    println!("force on p1: {:.1} {:.1} {:.1} N", out.force[3], out.force[4], out.force[5]);
    let row = &out.dfdx[3][3..];
    println!("dF/dX on p1: {:.1} {:.1} {:.1} N/m", row[0], row[1], row[2]);
    let counted = &rubber_band::OPERATIONS[..5];
    println!("operations of the kernel: {}", counted.iter().sum::<usize>());
}
