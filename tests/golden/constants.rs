// stages: ast, graph, schedule
const HALF: Real = 0.5;
const SOFT: Real = HALF * 3.0;
const UP: Vec3 = Vec3::new(0.0, 0.0, 1.0);

#[energy]
pub fn lift(p: Particle) -> Real {
    SOFT * UP.dot(&p.position) * PI
}
