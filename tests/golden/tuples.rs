// stages: ast, graph
#[energy]
pub fn pairs(p: Particle, k: Real) -> Real {
    let (x, (y, z)) = (p.position.x, (p.position.y, k));
    let pair = if x < y { (x, y) } else { (y, x) };
    pair.0 * z + pair.1
}
