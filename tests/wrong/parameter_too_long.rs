#[energy]
pub fn well(a: Particle, p: [[Real; 5000]; 5000]) -> Real {
    p[0][0] * a.position.x
}
