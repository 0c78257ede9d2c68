#[energy]
pub fn well(a: Particle, k: Real) -> Real {
    k * a.position.x
}

#[energy]
pub fn well_f32(a: Particle) -> Real {
    a.position.x
}

#[energy]
pub fn well_params(a: Particle) -> Real {
    a.position.x
}

#[energy]
pub fn Well(a: Particle) -> Real {
    a.position.x
}
