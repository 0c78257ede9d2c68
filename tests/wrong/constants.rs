//! Constants, and numbers that are too large or too small.

// case: constant_of_wrong_type
const K: Real = 2;
//~             ^ the constant is declared as `Real`
//~ ERROR expected `Real`, found an integer
//~ HELP write `2.0`

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    K * k * a.position.dot(&b.position)
}

// case: constant_without_type
const K = 1.0;
//~     ^ this is not Rust
//~ ERROR expected `:`
//~ HELP write the type behind a `:`, as in `x: Real`

#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    K * k * p.position.x
}

// case: constant_calls_function
const HALF: Real = half(1.0);
//~                ^^^^^^^^^ constants are evaluated before functions
//~ ERROR `half` is called in a constant
//~ HELP make constants of literals, `PI` and other constants

fn half(x: Real) -> Real {
    0.5 * x
}

#[energy]
pub fn well(p: Particle) -> Real {
    half(HALF) * p.position.norm_squared()
}

// case: constants_of_each_other
const K: Real = 2.0 * L;
//~   ^ its value leads back to it
//~ ERROR `K` is made of itself
//~ HELP give one of the constants a value of its own
const L: Real = 0.5 * K;

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    K * k * a.position.dot(&b.position)
}

// case: integer_overflow
const N: usize = 9223372036854775807;
const M: usize = N + 1;
//~              ^^^^^ beyond the range of `i64`
//~ ERROR an integer overflows

#[energy]
pub fn f(p: Particle, w: [Real; M]) -> Real {
    w[0] * p.position.x
}

// case: integer_division_by_zero
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    const N: usize = 0;
    a.position[3 / N] * k * b.position.x
//~            ^^^^^ 3 / 0
//~ ERROR an integer is divided by zero
}

// case: integer_literal_too_large
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * a.position[99999999999999999999] * b.position.x
//~                ^^^^^^^^^^^^^^^^^^^^ beyond the range of `i64`
//~ ERROR an integer that is too large
//~ HELP for a real write `99999999999999999999.0`
}

// case: literal_too_large
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    1e999 * k * a.position.dot(&b.position)
//~ ^^^^^ beyond the largest `f64`, about 1.8e308, or more than a thousand digits
//~ ERROR a number that is too large or too long
//~ HELP choose other units
}

// case: literal_too_small
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    1e-999 * k * a.position.dot(&b.position)
//~ ^^^^^^ below the least `f64`, about 5e-324
//~ ERROR a number that is too small
//~ HELP write `0.0`, or choose other units
}

// case: literal_with_unknown_suffix
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    2.0f16 * k * a.position.dot(&b.position)
//~ ^^^^^^ an unknown suffix
//~ ERROR `f16` is not a type of numbers
//~ HELP write `2.0` without it
}
