#[energy]
pub fn many(a: Particle, x: Real, y: Real, u: Vec3, m: Mat3, q: Quat) -> Real {
    let s = x / y + y.recip() + x.sqrt() + x.ln() + x.acos() + x.powi(-2) + x.powf(y);
    let t = u.normalize().x + m.inverse().trace() + q.angle() + x.atan2(y) + (x * x).sqrt();
    let r = u.normalize().dot(&a.position.normalize()).acos() + (x - x + 1.0) / 0.0 + x.abs().cbrt();
    s + t + r
}
