#[energy]
pub fn spring(a: Particle, b: Particle, k: f64, w: Vector3<f64>) -> Real {
    k * w.dot(&b.position) * a.position.x
}
