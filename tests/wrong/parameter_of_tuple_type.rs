#[energy]
pub fn well(a: Particle, p: (Real, Real)) -> Real {
    p.0 * a.position.x + p.1
}
