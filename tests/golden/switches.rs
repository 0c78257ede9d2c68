// stages: graph, derivative, schedule, c
#[energy]
pub fn kinks(p: Particle, k: Real) -> Real {
    let x = p.position.x;
    x.abs() + x.max(k) + p.position.y.min(k).signum() * x + p.position.z.clamp(-1.0, 1.0)
}
