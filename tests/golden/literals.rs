// stages: ast, graph, c
#[energy]
pub fn numbers(p: Particle) -> Real {
    1e-3 * p.position.x + 1_000.0 * p.position.y + 0.1 * p.position.z + 2.5e+1 / 3.0 * p.position.x.powi(2)
}
