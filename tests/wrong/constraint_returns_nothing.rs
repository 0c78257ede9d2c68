#[constraint]
pub fn nothing(a: Particle) -> () {
    let _gap = a.position;
}

#[force]
pub fn no_force(a: Particle) -> () {
    let _gap = a.position;
}
