#[constraint]
pub fn hinge(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3, axis: Vec3) -> (Vec3, Real) {
    let pa = a.position + a.orientation * arm_a;
    let pb = b.positon + b.orientation * arm_b;
    let u = a.orientation * axes;
    (pb - pa, u.dott(&(b.orientation * axis)) - 1)
}
