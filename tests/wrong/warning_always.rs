#[energy]
#[domain(angle = 3.0..3.3)]
pub fn nowhere(p: Particle, x: Real, angle: Real) -> Real {
    let numbers = (0.0 - 1.0).sqrt() + (-1.0).ln() + 2.0f64.acos() + 1.0 / 0.0;
    let ranges = (x.sin() + 3.0).acos() + (-x.abs() - 1.0).sqrt() + (-0.5).powf(x);
    let vectors = Vec3::zeros().normalize().x + Mat2::new(1.0, 1.0, 1.0, 1.0).inverse()[(0, 0)];
    let turned = angle.cos().sqrt() + 1.0 / angle.sin();
    numbers + ranges + vectors + turned + p.position.x
}
