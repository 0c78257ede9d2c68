//! Text that is not Rust.

// case: not_rust
spring: energy = 0.5 * k * x^2
//~   ^ this is not Rust
//~ ERROR expected `!`

// case: unclosed_brace
#[energy]
pub fn well(a: Particle) -> Real {
//~                              ^ the bracket that is opened here
//~ ERROR `{` is never closed
    a.position.x

// case: unclosed_bracket
#[energy]
pub fn well(a: Particle) -> Real {
    (a.position.x + 1.0
//~ ^ the bracket that is opened here
//~ ERROR `(` is never closed
//~ HELP `}` on line 4 comes first
}

// case: lone_closing_brace
#[energy]
pub fn well(a: Particle) -> Real {
    a.position.x
}
}
//~ 1-1 no bracket is open here
//~ ERROR unmatched `}`

// case: closes_nothing
#[energy]
pub fn well(a: Particle) -> Real {
    a.position.x + 1.0)
//~                   ^ `{` on line 2 is open here
//~ ERROR unmatched `)`
}

// case: missing_operator
#[energy]
pub fn well(a: Particle, k: Real) -> Real {
    k a.position.x
//~   ^ this is not Rust
//~ ERROR unexpected token, expected `;`
}

// case: missing_semicolon
#[energy]
pub fn well(a: Particle, k: Real) -> Real {
    let x = a.position.x
    k * x
//~ ^ this is not Rust
//~ ERROR expected `;`
}

// case: increment
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    let mut i = 0;
    i++;
//~   ^ this is not Rust
//~ ERROR expected an expression
//~ HELP write `i += 1` or `i -= 1`
    k * p.position.x
}

// case: ternary
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k > 0.0 ? p.position.x : 0.0
//~           ^ this is not Rust
//~ ERROR unexpected token, expected `;`
//~ HELP for a choice write `if condition { x } else { y }`
}

// case: comparison_chained
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    if 0.0 < k < 1.0 { 1.0 } else { p.position.x }
//~            ^ this is not Rust
//~ ERROR comparison operators cannot be chained
//~ HELP write `a < b && b < c`
}
