#[energy]
pub fn well(a: Particle) -> Real {
    a.position.x
}

#[energy]
pub fn well(b: Particle) -> Real {
    b.position.y
}
