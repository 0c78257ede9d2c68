//! Operators on values that the operators do not take.

// case: vector_plus_real
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position + 1.0;
//~         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ `Vec3` on the left, `Real` on the right
//~ ERROR `+` does not take `Vec3` and `Real`
//~ HELP for a vector with the number in every entry write `Vec3::new(x, x, x)`
    k * d.norm_squared()
}

// case: quotient_of_vectors
#[energy]
pub fn f(p: Particle, v: Vec3, m: Mat2) -> Real {
    (p.position / v).x + (1.0 / v).x + (m * v).x
//~ ^^^^^^^^^^^^^^^^ both are `Vec3`
//~ ERROR `/` does not take `Vec3`
//~ HELP divide entry by entry, `Vec3::new(u.x / v.x, u.y / v.y, u.z / v.z)`
//~                      ^^^^^^^^^ `Real` on the left, `Vec3` on the right
//~ ERROR `/` does not take `Real` and `Vec3`
//~ HELP divide entry by entry, `Vec3::new(u.x / v.x, u.y / v.y, u.z / v.z)`
//~                                    ^^^^^^^ `Mat2` on the left, `Vec3` on the right
//~ ERROR `*` does not take `Mat2` and `Vec3`
//~ HELP a matrix is multiplied with what has as many rows as it has columns
}

// case: row_times_vector
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    k * (d.transpose() * d)
//~     ^^^^^^^^^^^^^^^^^^^ a transposed `Vec3` on the left, `Vec3` on the right
//~ ERROR `*` does not take a transposed `Vec3` and `Vec3`
//~ HELP for the inner product write `u.dot(&v)`
}

// case: rotation_on_the_right
#[energy]
pub fn spring(a: Rigid, b: Particle, k: Real) -> Real {
    k * (b.position * a.orientation).x
//~     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^ `Vec3` on the left, `Quat` on the right
//~ ERROR `*` does not take `Vec3` and `Quat`
//~ HELP the rotation or matrix stands on the left, `m * v`
}

// case: quaternion_arithmetic
#[energy]
pub fn f(a: Rigid) -> Real {
    (a.orientation + a.orientation).w + (2.0 * a.orientation).w
//~ ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ both are `Quat`
//~ ERROR `+` does not take `Quat`
//~ HELP turns follow each other by `p * q`; a vector to calculate with is `q.scaled_axis()`
//~                                     ^^^^^^^^^^^^^^^^^^^^^ `Real` on the left, `Quat` on the right
//~ ERROR `*` does not take `Real` and `Quat`
//~ HELP turns follow each other by `p * q`; a vector to calculate with is `q.scaled_axis()`
}

// case: body_in_arithmetic
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b - a).norm_squared()
//~     ^^^^^^^ both are `Particle`
//~ ERROR `-` does not take `Particle`
//~ HELP take a field of the body, such as `.position`
}

// case: integer_variable_in_arithmetic
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut sum = 0.0;
    for i in 0..3 {
        sum += i * a.position[i] * b.position[i];
//~            ^^^^^^^^^^^^^^^^^ an integer on the left, `Real` on the right
//~ ERROR `*` does not take an integer and `Real`
//~ HELP write `(i as Real)` for an integer `i`
    }
    k * sum
}

// case: condition_times_real
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    (k > 0.0) * p.position.x
//~ ^^^^^^^^^^^^^^^^^^^^^^^^ `bool` on the left, `Real` on the right
//~ ERROR `*` does not take `bool` and `Real`
//~ HELP write `if condition { x } else { 0.0 }`
}

// case: compared_vectors
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if a.position == b.position { k } else { 0.0 }
//~    ^^^^^^^^^^^^^^^^^^^^^^^^ both are `Vec3`
//~ ERROR `==` does not take `Vec3`
//~ HELP compare reals, entry by entry
}

// case: remainder_of_reals
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (a.position.x % b.position.x)
//~     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ both are `Real`
//~ ERROR `%` does not take `Real`
//~ HELP `%` is for integers; reals have no remainder here
}

// case: power_by_caret
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = (b.position - a.position).norm();
    k * d ^ 2
//~       ^ no operator on reals
//~ ERROR `^` is not part of the force language
//~ HELP for a power write `x.powi(2)` or `x.powf(y)`
}

// case: power_by_stars
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k ** 2.0 + p.position.x
//~   ^^ no operator on reals
//~ ERROR `**` is not part of the force language
//~ HELP for a power write `x.powi(2)` or `x.powf(y)`
}
