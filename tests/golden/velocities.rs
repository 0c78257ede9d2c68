// stages: derivative, schedule
#[force]
pub fn spin_brake(a: Rigid, rate: Real) -> Wrench {
    Wrench { force: -rate * a.velocity, torque: -rate * a.angular_velocity.cross(&a.velocity) }
}
