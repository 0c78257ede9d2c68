//! Definitions and assignments: names that are taken or that C cannot spell, values that are missing or fixed.

// case: two_arguments_of_one_name
#[energy]
pub fn well(a: Particle, a: Particle) -> Real {
//~                      ^ the second of this name
//~ ERROR `a` is an argument twice
//~ HELP choose another name
    a.position.x
}

// case: two_functions_of_one_name
#[energy]
pub fn well(a: Particle) -> Real {
    a.position.x
}

#[energy]
pub fn well(b: Particle) -> Real {
//~    ^^^^ the function that comes second
//~ ERROR `well` is defined twice
//~ HELP choose another name
    b.position.y
}

// case: kernels_that_meet
#[energy]
pub fn well(a: Particle, k: Real) -> Real {
    k * a.position.x
}

#[energy]
pub fn well_f32(a: Particle) -> Real {
//~    ^^^^^^^^ both define `well_f32`
//~ ERROR kernels of `well_f32` and `well` would have the same name
//~ HELP choose another name
    a.position.x
}

#[energy]
pub fn well_params(a: Particle) -> Real {
//~    ^^^^^^^^^^^ both define `well_params_f64`
//~ ERROR kernels of `well_params` and `well` would have the same name
//~ HELP choose another name
    a.position.x
}

#[energy]
pub fn Well(a: Particle) -> Real {
//~    ^^^^ both define `well`
//~ ERROR kernels of `Well` and `well` would have the same name
//~ HELP choose another name
    a.position.x
}

// case: kernel_named_like_ours
#[energy]
pub fn forcec_rigid(a: Particle) -> Real {
//~    ^^^^^^^^^^^^ what is in `forcec.h` has this name already
//~ ERROR `forcec_rigid` is built in
//~ HELP choose another name
    a.position.x
}

// case: name_of_built_in
const PI: Real = 3.0;
//~   ^^ a constant has this name already
//~ ERROR `PI` is built in
//~ HELP choose another name

#[energy]
pub fn well(a: Particle) -> Real {
    PI * a.position.x
}

// case: variable_named_like_constant
const K: Real = 3.0;

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let K = 2.0;
//~     ^ Rust compares with the constant here and binds nothing
//~ ERROR `K` is a constant
//~ HELP choose another name
    K * k * a.position.dot(&b.position)
}

// case: raw_identifier
#[energy]
pub fn spring(a: Particle, b: Particle, r#type: Real) -> Real {
//~                                     ^^^^^^ kernels have no way to write this name
//~ ERROR `r#type` is a raw identifier
//~ HELP call it `type_`
    r#type * a.position.dot(&b.position)
//~ ^^^^^^ kernels have no way to write this name
//~ ERROR `r#type` is a raw identifier
//~ HELP call it `type_`
}

// case: recursion
fn factorial(x: Real) -> Real {
    x * factorial(x - 1.0)
//~     ^^^^^^^^^ `factorial` calls `factorial`
//~ ERROR `factorial` calls itself
//~ HELP helpers are inlined; repeat with `for i in 0..n` over a constant range
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * factorial(a.position.dot(&b.position))
}

// case: mutual_recursion
fn even(x: Real) -> Real {
    odd(x - 1.0)
}

fn odd(x: Real) -> Real {
    even(x - 1.0)
//~ ^^^^ `even` calls `odd` calls `even`
//~ ERROR `even` calls itself
//~ HELP helpers are inlined; repeat with `for i in 0..n` over a constant range
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * even(a.position.dot(&b.position))
}

// case: let_without_value
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d;
//~ ^^^ nothing is bound
//~ ERROR a `let` without a value
//~ HELP write the value: `let x = if … { … } else { … };`
    d = k * a.position.dot(&b.position);
    d
}

// case: assigned_without_mut
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let energy = 0.0;
    energy += k * a.position.dot(&b.position);
//~ ^^^^^^ not declared `mut`
//~ ERROR `energy` cannot be assigned
//~ HELP write `let mut energy = …;`
    energy
}

// case: assigned_constant_expression
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k = 2.0;
//~ ^ not declared `mut`
//~ ERROR `k` cannot be assigned
//~ HELP write `let mut k = …;`
    k * a.position.dot(&b.position)
}

// case: assigned_body
#[energy]
pub fn f(mut p: Particle, mut k: Real) -> Real {
    k = 2.0;
    p.position.x = 3.0;
//~   ^^^^^^^^ no such part of `Particle` that can change
//~ ERROR `position` cannot be assigned
//~ HELP a body stays as it is; copy the field, `let mut position = ….position;`
    p.position.x * k
}
