#[energy]
pub fn spring(a: Rigid, b: Particle, k: Real) -> Real {
    k * (b.position * a.orientation).x
}
