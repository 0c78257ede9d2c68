//! Loops that cannot be unrolled.

// case: loop_over_array
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for x in [1.0, 2.0] {
//~          ^^^^^^^^^^ not a range with two ends
//~ ERROR a loop runs over a constant range
//~ HELP write `for i in 0..n`, and index with `i`
        sum += x;
    }
    k * sum * a.position.dot(&b.position)
}

// case: loop_over_real_range
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in 0..k {
//~             ^ the range of a loop is made of integer constants
//~ ERROR expected an integer, found `Real`
//~ HELP integers are literals, integer constants and variables of loops
        sum += 1.0;
    }
    sum * a.position.dot(&b.position)
}

// case: loop_reversed
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in (0..3).rev() {
//~                 ^^^ not a range with two ends
//~ ERROR a loop runs over a constant range
//~ HELP count up with `for i in 0..n` and use `n - 1 - i`
        sum = sum * k + a.position[i] * b.position[i];
    }
    sum
}

// case: loop_of_c
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    for (int i = 0; i < 3; i++) {}
//~          ^ this is not Rust
//~ ERROR expected `,`
//~ HELP write `for i in 0..n { … }`
    k * p.position.x
}

// case: loop_too_long
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for _ in 0..1_000_000_000 {
//~ ^^^^^^^^^^^^^^^^^^^^^^^^^ 1000000000 iterations; at most 1000000 can be unrolled
//~ ERROR the loop is too long to unroll
//~ HELP shorten the ranges
        sum += k;
    }
    sum * a.position.dot(&b.position)
}

// case: loop_with_value
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    for i in 0..3 {
        a.position[i]
//~     ^^^^^^^^^^^^^ this is `Real`
//~ ERROR the body of a loop has a value
//~ HELP assign it to a `let mut` variable, as in `sum += …;`
    }
    k * b.position.x
}

// case: break_in_loop
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in 0..3 {
        if i == 2 { break; }
//~                 ^^^^^ every iteration runs
//~ ERROR `break`s are not part of the force language
//~ HELP put the rest of the iteration into an `if`
        sum += a.position[i] * b.position[i];
    }
    k * sum
}

// case: while_loop
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut x = k;
    while x > 1.0 {
//~ ^^^^^ how often it runs is not known
//~ ERROR `while` loops are not part of the force language
//~ HELP write `for i in 0..n` over a constant range
        x *= 0.5;
    }
    x * a.position.dot(&b.position)
}
