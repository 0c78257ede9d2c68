#[constraint]
pub fn same(a: Particle) -> Particle {
    a
}
