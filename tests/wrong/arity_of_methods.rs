#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k.atan2() + k.max(1.0, 2.0) + p.position.norm(2) + k.powi() + Vec3::new(1.0, 2.0).x
}
