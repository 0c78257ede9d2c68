//! What a constraint, an energy and a force may read, and what each returns.

// case: constraint_returns_body
#[constraint]
pub fn same(a: Particle) -> Particle {
//~                         ^^^^^^^^ not the rows of a constraint
//~ ERROR a constraint does not return `Particle`
//~ HELP return `Real`, a vector, or a tuple or array of these
    a
}

// case: constraint_returns_matrix
#[constraint]
pub fn shape(a: Rigid) -> Mat3 {
//~                       ^^^^ not the rows of a constraint
//~ ERROR a constraint does not return `Mat3`
//~ HELP return `Real`, a vector, or a tuple or array of these
    a.orientation.to_rotation_matrix().into_inner()
}

// case: constraint_returns_nothing
#[constraint]
pub fn nothing(a: Particle) -> () {
//~                            ^^ not the rows of a constraint
//~ ERROR the constraint `nothing` returns no value
//~ HELP return `Real`, a vector, or a tuple or array of these
    let _gap = a.position;
}

#[force]
pub fn no_force(a: Particle) -> () {
//~                             ^^ a force on every body, in order: `Wrench` for `Rigid`, `Vec3` for `Particle`
//~ ERROR the force `no_force` returns no value
//~ HELP return `Vec3`
    let _gap = a.position;
}

// case: energy_returns_vector
#[energy]
pub fn well(a: Particle) -> Vec3 {
//~                         ^^^^ an energy is one number
//~ ERROR an energy does not return `Vec3`
//~ HELP return `Real`
    a.position
}

// case: tuple_for_energy
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    let parts = (k, p.position.x);
    (parts.0, parts.2)
//~                 ^ no such field on `(Real, Real)`
//~ ERROR unknown field `2`
//~ HELP the tuple has 2 elements, counted from 0
}

#[energy]
pub fn g(p: Particle) -> (Real, Real) {
//~                      ^^^^^^^^^^^^ an energy is one number
//~ ERROR an energy does not return `(Real, Real)`
//~ HELP return `Real`
    (p.position.x, 1.0)
}

// case: force_returns_too_few
#[force]
pub fn pull(a: Rigid, b: Particle, k: Real) -> Wrench {
//~                                            ^^^^^^ a force on every body, in order: `Wrench` for `Rigid`, `Vec3` for `Particle`
//~ ERROR the force `pull` does not return `Wrench`
//~ HELP return `(Wrench, Vec3)`
    Wrench { force: k * (b.position - a.position), torque: Vec3::zeros() }
}

// case: force_returns_vector_for_rigid
#[force]
pub fn drag(a: Rigid, k: Real) -> Vec3 {
//~                               ^^^^ a force on every body, in order: `Wrench` for `Rigid`, `Vec3` for `Particle`
//~ ERROR the force `drag` does not return `Vec3`
//~ HELP return `Wrench`
    -k * a.velocity
}

// case: no_return_type
#[energy]
pub fn well(a: Particle) {
//~        ^^^^^^^^^^^^^ no `->` after the arguments
//~ ERROR `well` does not say what it returns
//~ HELP write `-> Real`, the energy
    a.position.x
}

// case: value_dropped_by_semicolon
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
//~                                                 ^^^^ `spring` returns `Real`, but its body has no value
//~ ERROR expected `Real`, found no value
//~ HELP end the block with an expression, without `;`
    let d = b.position - a.position;
    k * d.norm_squared();
}

// case: constraint_reads_velocity
#[constraint]
pub fn slow(a: Particle) -> Vec3 {
    a.velocity
//~   ^^^^^^^^ `slow` may depend on positions and orientations only
//~ ERROR a constraint reads a velocity
//~ HELP leave it to the `damping` of the constraint, or write a `#[force]`
}

// case: energy_reads_velocity_in_helper
fn kinetic(a: Rigid) -> Real {
    0.5 * a.angular_velocity.norm_squared()
//~         ^^^^^^^^^^^^^^^^ `spin` may depend on positions and orientations only
//~ ERROR an energy reads a velocity
//~ HELP write a `#[force]` beside the energy
}

#[energy]
pub fn spin(a: Rigid) -> Real {
    kinetic(a)
}
