#[energy]
pub fn f(p: Particle, w: [Real; 3]) -> Real {
    w[3] + w[-1] + p.position[3]
}
