//! Attributes of functions, their options, and lists of allowed warnings.

// case: unknown_attribute
#[constrant]
//~ 1-12 nothing the compiler knows
//~ ERROR unknown attribute `constrant`
//~ HELP did you mean `#[constraint]`?
pub fn pin(a: Particle, target: Vec3) -> Vec3 {
    a.position - target
}

// case: two_kinds
#[constraint]
#[energy]
//~ 1-9 it is a constraint already
//~ ERROR a function is one kind of force
//~ HELP keep one of the attributes
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: energy_twice
#[energy]
#[force]
//~ 1-8 it is an energy already
//~ ERROR a function is one kind of force
//~ HELP keep one of the attributes
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: conditional_compilation
#[cfg(feature = "floor")]
//~ 1-25 the compiler does not know the configuration of your crate
//~ ERROR conditional compilation is not part of the force language
//~ HELP put what differs into a file of its own
#[constraint]
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: unknown_option
#[constraint(unilaterl)]
//~          ^^^^^^^^^ no option of `#[constraint]`
//~ ERROR unknown option `unilaterl`
//~ HELP did you mean `unilateral`?
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: malformed_options
#[constraint(unilateral per_row)]
//~                     ^^^^^^^ expected `,`
//~ ERROR the options of `#[constraint]` are malformed
//~ HELP write them as in `#[constraint(unilateral, per_row)]`
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: option_malformed
#[energy(real)]
//~      ^^^^ it takes the name of a precision, or a list of them
//~ ERROR the option `real` is malformed
//~ HELP write `real = f32`
pub fn f(p: Particle) -> Real {
    p.position.x
}

#[constraint(unilateral = true)]
//~          ^^^^^^^^^^ it stands by itself
//~ ERROR the option `unilateral` is malformed
//~ HELP write `unilateral`
pub fn g(p: Particle) -> Real {
    p.position.x
}

// case: option_of_energy
#[energy(unilateral)]
//~      ^^^^^^^^^^ this is `#[energy]`
//~ ERROR `unilateral` is an option of constraints
//~ HELP an energy or a force is already all there is to it; leave the option out
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: option_twice
#[constraint(per_row, per_row)]
//~                   ^^^^^^^ the second time
//~ ERROR `per_row` is stated twice
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: unknown_precision
#[constraint(real = f16)]
//~                 ^^^ no such precision
//~ ERROR unknown precision `f16`
//~ HELP write `f64` or `f32`
pub fn floor(a: Particle) -> Real {
    a.position.z
}

// case: allow_misspelt
#[energy]
#[allow(singluar, reason = "the spring is never short")]
//~     ^^^^^^^^ neither forcec nor rustc has it
//~ ERROR unknown warning `singluar`
//~ HELP did you mean `singular`?
pub fn spring(p: Particle) -> Real {
    p.position.norm()
}

// case: allow_denied
#[energy]
#[deny(singular)]
//~    ^^^^^^^^ a warning of forcec, not of rustc
//~ ERROR `singular` cannot be set to `deny`
//~ HELP write `#[allow(singular, reason = "…")]`, or deny warnings on the command line
#[expect(nonlinear, unused, reason = "to see")]
//~      ^^^^^^^^^ a warning of forcec, not of rustc
//~ ERROR `nonlinear` cannot be set to `expect`
//~ HELP write `#[allow(nonlinear, reason = "…")]`, or deny warnings on the command line
pub fn spring(p: Particle) -> Real {
    p.position.norm()
}
