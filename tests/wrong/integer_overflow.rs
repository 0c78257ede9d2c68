const N: usize = 9223372036854775807;
const M: usize = N + 1;

#[energy]
pub fn f(p: Particle, w: [Real; M]) -> Real {
    w[0] * p.position.x
}
