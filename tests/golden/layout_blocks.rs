// stages: schedule, header, c, rust
// layout: blocks, 1
/// Lamp: a body hangs on a spring from a particle, and a wind of constant force pushes the body.
#[energy]
fn lamp(hook: Particle, shade: Rigid, arm: Vec3, wind: Vec3, k: Real) -> Real {
    let spring = shade.position + shade.orientation * arm - hook.position;
    0.5 * k * spring.norm_squared() - wind.dot(shade.position)
}
