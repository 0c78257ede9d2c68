// stages: ast, graph, c
fn square(x: Real) -> Real {
    x * x
}

fn ends(p: Particle, q: Particle) -> (Vec3, Vec3) {
    (p.position, q.position)
}

#[energy]
pub fn spring(p: Particle, q: Particle) -> Real {
    let (from, to) = ends(p, q);
    0.5 * square((to - from).x)
}
