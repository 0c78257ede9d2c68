fn strech(d: Vec3) -> Real {
    d.norm_squared()
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    stretch(b.position - a.position) * k
}
