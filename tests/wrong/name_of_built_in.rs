const PI: Real = 3.0;

#[energy]
pub fn well(a: Particle) -> Real {
    PI * a.position.x
}
