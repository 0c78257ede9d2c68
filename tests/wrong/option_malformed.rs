#[energy(real)]
pub fn f(p: Particle) -> Real {
    p.position.x
}

#[constraint(unilateral = true)]
pub fn g(p: Particle) -> Real {
    p.position.x
}
