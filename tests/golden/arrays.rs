// stages: ast, graph
#[energy]
pub fn knots(p: Particle, points: [Vec3; 2]) -> Real {
    let ways = [points[0] - p.position, points[1] - p.position];
    ways[0].dot(&ways[1])
}
