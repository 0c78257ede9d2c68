//! Arguments of a force function: bodies first, then parameters.

// case: no_body
#[energy]
pub fn nothing(k: Real) -> Real {
//~    ^^^^^^^ none of its arguments is a body
//~ ERROR `nothing` acts on no body
//~ HELP take a `Rigid` or a `Particle` as its first argument
    k
}

// case: body_behind_parameter
#[constraint]
pub fn distance(a: Particle, rest: Real, b: Particle) -> Real {
//~                                      ^ a body
//~ ERROR the body `b` stands behind a parameter
//~ HELP write the bodies first, then the parameters
    (b.position - a.position).norm_squared() - rest
}

// case: array_of_bodies
#[energy]
pub fn sum(p: [Particle; 3]) -> Real {
//~           ^^^^^^^^^^^^^ this is `[Particle; 3]`
//~ ERROR `p` cannot be a parameter
//~ HELP take the bodies as arguments of their own
    p[0].position.x + p[1].position.x + p[2].position.x
}

// case: argument_pattern
#[energy]
pub fn well((a, b): (Particle, Particle)) -> Real {
//~         ^^^^^^ a pattern stands here
//~ ERROR an argument is a plain name
//~ HELP give it a name, and take it apart with `let (p, q) = name;`
    a.position.dot(&b.position)
}

// case: default_argument
#[energy]
pub fn f(p: Particle, k: Real = 1.0) -> Real {
//~                           ^ this is not Rust
//~ ERROR expected `,`
//~ HELP an argument has no default: whoever calls the kernel gives every value
    k * p.position.x
}

// case: parameter_of_integer_type
#[energy]
pub fn well(a: Particle, n: usize) -> Real {
//~                         ^^^^^ this is an integer
//~ ERROR `n` cannot be a parameter
//~ HELP write a `const` for what is known while compiling, or take a `Real`
    n as Real * a.position.x
}

// case: parameter_of_tuple_type
#[energy]
pub fn well(a: Particle, p: (Real, Real)) -> Real {
//~                         ^^^^^^^^^^^^ this is `(Real, Real)`
//~ ERROR `p` cannot be a parameter
//~ HELP take its parts as parameters of their own
    p.0 * a.position.x + p.1
}

// case: parameter_too_long
#[energy]
pub fn well(a: Particle, p: [[Real; 5000]; 5000]) -> Real {
//~                         ^^^^^^^^^^^^^^^^^^^^ 25000000 reals; a parameter has at most 1000000
//~ ERROR `p` cannot be a parameter
//~ HELP parameters are `Real`, vectors, matrices, `Quat` and arrays of these
    p[0][0] * a.position.x
}

// case: parameter_stiffness
#[constraint]
pub fn pin(a: Particle, stiffness: Real) -> Vec3 {
//~                     ^^^^^^^^^ added by the compiler
//~ ERROR a constraint has a `stiffness` already
//~ HELP choose another name, or leave the parameter out: the compiler multiplies by it
    stiffness * a.position
}
