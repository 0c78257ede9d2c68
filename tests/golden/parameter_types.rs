// stages: header, schedule, rust
#[force]
pub fn everything(
    p: Particle,
    real: Real,
    vec2: Vec2,
    vec3: Vec3,
    vec4: Vec4,
    mat2: Mat2,
    mat3: Mat3,
    quat: Quat,
    reals: [Real; 2],
    matrices: [Mat2; 2],
    quats: [Quat; 2],
) -> Vec3 {
    let sum = real + vec2.y + vec4.w + mat2[(0, 1)] + reals[1] + matrices[1][(1, 0)];
    quat * (mat3 * vec3) + quats[1] * Vec3::x() * sum
}
