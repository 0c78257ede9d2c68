fn square(x: Real) -> Real {
    x * y
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let p = a.position;
    k * (square(p.x) + square(p.y) + square(b.position.z))
}
