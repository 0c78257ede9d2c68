// stages: header, c, rust
//! Names that C, C++, Rust and the kernels themselves keep.

#[force]
pub fn int(out: Particle, params: Particle, double: Real, class: Real, crate_: Real) -> (Vec3, Vec3) {
    let dfdx = out.position * double;
    let static_ = params.position * class * crate_;
    (dfdx, static_)
}
