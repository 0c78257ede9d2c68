#[domain(x = 0.0..1.0)]
fn square(x: Real) -> Real {
    x * x
}

#[energy]
pub fn well(a: Particle) -> Real {
    square(a.position.x)
}
