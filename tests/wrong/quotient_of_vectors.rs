#[energy]
pub fn f(p: Particle, v: Vec3, m: Mat2) -> Real {
    (p.position / v).x + (1.0 / v).x + (m * v).x
}
