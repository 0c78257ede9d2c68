//! Warnings: values or derivatives that may not exist, and values that nothing uses.

// case: warning_acos
#[energy]
#[domain(u = unit, v = unit)]
pub fn bend(a: Rigid, u: Vec3, v: Vec3) -> Real {
    (a.orientation * u).dot(&v).acos()
//~ ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ no derivative there
//~ WARNING[singular] `acos` of a value that can reach -1 or 1: its derivative divides by zero
//~ HELP keep it inside, as in `x.clamp(-0.999, 0.999)`, or take the angle of two vectors, `u.angle(&v)`
}

// case: warning_powers_at_zero
/// What is missing at zero depends on the exponent.
#[energy]
#[domain(x = 0.0..1.0)]
fn powers(p: Particle, x: Real) -> Real {
    let y = p.position.norm_squared() + x;
    y.powf(-1.5) + y.powf(0.7) + y.powf(1.5) + y.powf(2.5) + y.powf(3.0) + y.powf(x)
//~ ^^^^^^^^^^^^ gives no finite number there
//~ WARNING[singular] `powf` of a value that can be zero
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
//~                ^^^^^^^^^^^ no derivative there
//~ WARNING[singular] `powf` of a value that can be zero: its derivative divides by zero
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
//~                              ^^^^^^^^^^^ no second derivative there
//~ WARNING[singular] `powf` of a value that can be zero: its second derivative divides by zero
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
//~                                                                        ^^^^^^^^^ no derivative there
//~ WARNING[singular] `powf` of a value that can be zero: its derivative divides by zero
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
}

// case: warning_singular_functions
#[energy]
pub fn many(a: Particle, x: Real, y: Real, u: Vec3, m: Mat3, q: Quat) -> Real {
    let s = x / y + y.recip() + x.sqrt() + x.ln() + x.acos() + x.powi(-2) + x.powf(y);
//~         ^^^^^ gives no finite number where the divisor is zero
//~ WARNING[singular] division by a value that can be zero
//~ HELP keep the divisor away from zero, as in `x / y.max(1e-9)`, or state its range with `#[domain(…)]`
//~                 ^^^^^^^^^ gives no finite number where the divisor is zero
//~ WARNING[singular] division by a value that can be zero
//~ HELP keep the divisor away from zero, as in `x / y.max(1e-9)`, or state its range with `#[domain(…)]`
//~                             ^^^^^^^^ gives no finite number there
//~ WARNING[singular] `sqrt` of a value that can be below 0
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
//~                                        ^^^^^^ gives no finite number there
//~ WARNING[singular] `ln` of a value that can be zero or negative
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
//~                                                 ^^^^^^^^ gives no finite number there
//~ WARNING[singular] `acos` of a value that can be outside of -1 … 1
//~ HELP keep it inside, as in `x.clamp(-0.999, 0.999)`, or take the angle of two vectors, `u.angle(&v)`
//~                                                            ^^^^^^^^^^ gives no finite number where the value is zero
//~ WARNING[singular] a negative power of a value that can be zero
//~ HELP keep the value away from zero, as in `y.max(1e-9)`, or state its range with `#[domain(…)]`
//~                                                                         ^^^^^^^^^ gives no finite number there
//~ WARNING[singular] `powf` of a value that can be below 0
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
    let t = u.normalize().x + m.inverse().trace() + q.angle() + x.atan2(y) + (x * x).sqrt();
//~         ^^^^^^^^^^^^^ a zero vector has no direction
//~ WARNING[singular] `normalize` of a vector that can be zero divides by zero
//~ HELP write `v / v.norm().max(1e-9)`, or state `#[domain(v = unit)]` of a parameter
//~                           ^^^^^^^^^^^ divides by the determinant
//~ WARNING[singular] `inverse` of a matrix whose determinant can be zero
//~ HELP take the inverse as a parameter, or make sure that the matrix is never singular
//~                                                 ^^^^^^^^^ the angle has a kink at zero
//~ WARNING[singular] `angle` of a rotation that can be the identity: its derivative divides by zero
//~ HELP use `scaled_axis()`, which is smooth there
//~                                                             ^^^^^^^^^^ no derivative where both are zero
//~ WARNING[singular] `atan2` of values that can both be zero: its derivative divides by zero
//~ HELP keep one of them away from zero
//~                                                                          ^^^^^^^^^^^^^^ no derivative there
//~ WARNING[singular] `sqrt` of a value that can be zero: its derivative divides by zero
//~ HELP add a positive constant, as in `(x + 1e-12).sqrt()`, or state its range with `#[domain(…)]`
    let r = u.normalize().dot(&a.position.normalize()).acos() + (x - x + 1.0) / 0.0 + x.abs().cbrt();
//~         ^^^^^^^^^^^^^ a zero vector has no direction
//~ WARNING[singular] `normalize` of a vector that can be zero divides by zero
//~ HELP write `v / v.norm().max(1e-9)`, or state `#[domain(v = unit)]` of a parameter
//~         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ no derivative there
//~ WARNING[singular] `acos` of a value that can reach -1 or 1: its derivative divides by zero
//~ HELP keep it inside, as in `x.clamp(-0.999, 0.999)`, or take the angle of two vectors, `u.angle(&v)`
//~                            ^^^^^^^^^^^^^^^^^^^^^^ a zero vector has no direction
//~ WARNING[singular] `normalize` of a vector that can be zero divides by zero
//~ HELP write `v / v.norm().max(1e-9)`, or state `#[domain(v = unit)]` of a parameter
//~                                                             ^^^^^^^^^^^^^^^^^^^ the divisor is always zero: no finite number at any state
//~ WARNING[singular] division by zero
//~ HELP write the divisor that is meant, or leave the quotient out
//~                                                                                   ^^^^^^^^^^^^^^ no derivative there
//~ WARNING[singular] `cbrt` of a value that can be zero: its derivative divides by zero
//~ HELP keep it away with `.max(1e-9)`, or state its range with `#[domain(…)]`
    s + t + r
}

// case: warning_always
#[energy]
#[domain(angle = 3.0..3.3)]
pub fn nowhere(p: Particle, x: Real, angle: Real) -> Real {
    let numbers = (0.0 - 1.0).sqrt() + (-1.0).ln() + 2.0f64.acos() + 1.0 / 0.0;
//~               ^^^^^^^^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `sqrt` of a value that is always below 0
//~ HELP write the value that is meant
//~                                    ^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `ln` of a value that is always zero or negative
//~ HELP write the value that is meant
//~                                                  ^^^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `acos` of a value that is always outside of -1 … 1
//~ HELP write the value that is meant
//~                                                                  ^^^^^^^^^ the divisor is always zero: no finite number at any state
//~ WARNING[singular] division by zero
//~ HELP write the divisor that is meant, or leave the quotient out
    let ranges = (x.sin() + 3.0).acos() + (-x.abs() - 1.0).sqrt() + (-0.5).powf(x);
//~              ^^^^^^^^^^^^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `acos` of a value that is always outside of -1 … 1
//~ HELP write the value that is meant
//~                                       ^^^^^^^^^^^^^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `sqrt` of a value that is always below 0
//~ HELP write the value that is meant
//~                                                                 ^^^^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `powf` of a value that is always below 0
//~ HELP write the value that is meant
    let vectors = Vec3::zeros().normalize().x + Mat2::new(1.0, 1.0, 1.0, 1.0).inverse()[(0, 0)];
//~               ^^^^^^^^^^^^^^^^^^^^^^^^^ a zero vector has no direction
//~ WARNING[singular] `normalize` of a vector that is always zero
//~ HELP write the vector that is meant
//~                                             ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ divides by the determinant
//~ WARNING[singular] `inverse` of a matrix whose determinant is always zero
//~ HELP write the matrix that is meant
    let turned = angle.cos().sqrt() + 1.0 / angle.sin();
//~              ^^^^^^^^^^^^^^^^^^ gives no finite number at any state
//~ WARNING[singular] `sqrt` of a value that is always below 0
//~ HELP write the value that is meant
//~                                   ^^^^^^^^^^^^^^^^^ gives no finite number where the divisor is zero
//~ WARNING[singular] division by a value that can be zero
//~ HELP keep the divisor away from zero, as in `x / y.max(1e-9)`, or state its range with `#[domain(…)]`
    numbers + ranges + vectors + turned + p.position.x
}

// case: warning_dropped
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    p.position.norm_squared();
//~ ^^^^^^^^^^^^^^^^^^^^^^^^^ computed and dropped
//~ WARNING[unused] a value that nothing uses
//~ HELP leave it out, bind it by `let`, or assign it
    k * p.position.x
}

// case: warning_allowed
#![allow(outside_domain, reason = "for the whole file")]

fn length(v: Vec3) -> Real {
    v.norm()
//~ ^^^^^^^^ the length has no derivative where the vector is zero
//~ WARNING[singular] `norm` of a vector that can be zero: its derivative divides by zero
//~ HELP write `(v.norm_squared() + 1e-12).sqrt()`, or formulate with the vector itself
}

#[allow(singular, reason = "a helper answers for all who call it")]
fn known(v: Vec3) -> Real {
    v.norm()
}

/// Warned of: `length` and `unread`.
#[energy]
#[allow(clippy::too_many_arguments, unused_variables, dead_code)]
pub fn plain(p: Particle, unread: Real) -> Real {
//~                       ^^^^^^ nothing reads it
//~ WARNING[unused] unused parameter `unread`
//~ HELP leave it out, or call it `_unread`
    length(p.position) + known(p.position)
}

/// Nothing of this is warned of, but `length` because of `plain`.
#[energy]
#[allow(singular, unused, reason = "the spring is never short")]
pub fn answered(p: Particle, unread: Real) -> Real {
    p.position.y;
    length(p.position) + p.position.norm()
}

#[forces]
#[allow(unused, reason = "for the module")]
mod inner {
    /// Warned of because there is no reason.
    #[energy]
    #[allow(singular)]
//~         ^^^^^^^^ no `reason` here
//~ WARNING[missing_reason] `singular` is allowed without a reason
//~ HELP write `#[allow(singular, reason = "…")]`
    pub fn bare(p: Particle, unread: Real) -> Real {
        p.position.norm()
    }

    #[energy]
    pub fn after(p: Particle, unread: Real) -> Real {
        p.position.norm()
//~     ^^^^^^^^^^^^^^^^^ the length has no derivative where the vector is zero
//~ WARNING[singular] `norm` of a vector that can be zero: its derivative divides by zero
//~ HELP write `(v.norm_squared() + 1e-12).sqrt()`, or formulate with the vector itself
    }
}
