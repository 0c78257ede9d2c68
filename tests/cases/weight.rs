//! A weight: dF/dX is zero, so that nothing is added with `--layout accumulate --outputs dfdx`.

#[energy]
pub fn weight(a: Particle, mass: Real) -> Real { mass * 9.81 * a.position.z }
