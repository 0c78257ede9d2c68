// stages: ast, graph, derivative, c, rust
#[energy]
pub fn stair(p: Particle, a: Real) -> Real {
    let x = p.position.x;
    if x < 0.0 {
        0.0
    } else if x < a && !(a == 1.0) || x > 2.0 {
        if x >= 0.5 { x } else { x * x }
    } else {
        a * x
    }
}
