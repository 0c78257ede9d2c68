//! A rubber band whose kernel the build script made.

include!(concat!(env!("OUT_DIR"), "/mod.rs"));

use bands::{Particle, rubber_band};

fn main() {
    let p0 = Particle::default();
    let p1 = Particle { position: [1.0, 2.0, 2.0], ..Particle::default() };
    let params = rubber_band::Params { rest_length: 1.0, stiffness: 10.0 };
    let mut out = rubber_band::Output::default();
    rubber_band::evaluate(&p0, &p1, &params, &mut out);
    println!("force on p1: {:.1} {:.1} {:.1} N", out.force[3], out.force[4], out.force[5]);
    let row = &out.dfdx[3][3..];
    println!("dF/dX on p1: {:.1} {:.1} {:.1} N/m", row[0], row[1], row[2]);
}
