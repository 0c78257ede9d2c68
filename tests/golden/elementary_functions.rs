// stages: derivative, c, rust
#[energy]
pub fn waves(p: Particle, k: Real) -> Real {
    let (x, y) = (p.position.x, p.position.y);
    (x.sin_cos().0 + k.exp()) * y.atan2(k) + x.tanh() + y.hypot(2.0) + k.powf(1.5) + x.ln_1p().cbrt()
}
