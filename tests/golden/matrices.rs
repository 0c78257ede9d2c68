// stages: ast, graph, schedule
#[energy]
pub fn strain(p: Particle, m: Mat2) -> Real {
    let x = Vec2::new(p.position.x, p.position.y);
    let f = m * Mat2::from_columns(&[x, Vec2::y()]) - Mat2::identity();
    f.determinant() + f.transpose().trace() + (m.inverse() * x).x
}
