#[energy]
pub fn f(a: Rigid, p: Particle) -> Real {
    a.pos.x + a.rotation.w + a.omega.x + a.mass + p.rotation.w
}
