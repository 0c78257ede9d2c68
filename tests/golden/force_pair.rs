// stages: ast, derivative, schedule
#[force]
pub fn tow(a: Particle, b: Rigid, pull: Real) -> (Vec3, Wrench) {
    let force = pull * (b.position - a.position);
    (force, Wrench { force: -force, torque: Vec3::zeros() })
}
