// stages: graph, schedule, c
#[energy]
pub fn steep(p: Particle) -> Real {
    p.position.x.powi(7) + p.position.y.powi(-3) + p.position.z.recip()
}
