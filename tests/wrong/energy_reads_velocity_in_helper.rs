fn kinetic(a: Rigid) -> Real {
    0.5 * a.angular_velocity.norm_squared()
}

#[energy]
pub fn spin(a: Rigid) -> Real {
    kinetic(a)
}
