#[energy]
pub fn sum(p: [Particle; 3]) -> Real {
    p[0].position.x + p[1].position.x + p[2].position.x
}
