fn energy(k: Real, d: Vec3) -> Real {
    k * d.norm_squared()
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    energy(2, b.position - a.position) * k
}
