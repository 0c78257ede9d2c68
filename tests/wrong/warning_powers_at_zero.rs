/// What is missing at zero depends on the exponent.
#[energy]
#[domain(x = 0.0..1.0)]
fn powers(p: Particle, x: Real) -> Real {
    let y = p.position.norm_squared() + x;
    y.powf(-1.5) + y.powf(0.7) + y.powf(1.5) + y.powf(2.5) + y.powf(3.0) + y.powf(x)
}
