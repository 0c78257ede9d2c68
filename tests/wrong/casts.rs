#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    let n = k as i32;
    let push = (k > 0.0) as Real;
    let x = p.position as Real;
    push * x
}
