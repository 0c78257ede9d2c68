// stages: ast, graph, schedule
#[energy]
pub fn chain(p: Particle, weights: [Real; 3]) -> Real {
    let mut sum = 0.0;
    let mut product = 1.0;
    for i in 0..3 {
        sum += weights[i] * (i as Real + 1.0);
        product *= p.position[i];
        sum -= product / 2.0;
    }
    sum * product
}
