// stages: warnings, ast
#[energy]
#[domain(length = 0.1..2.0, axis = unit)]
pub fn bounded(p: Particle, length: Real, width: Real, axis: Vec3) -> Real {
    let safe = p.position.dot(&axis) / length;
    safe / width + axis.norm() + p.position.norm()
}
