//! Values of a wrong type: declared, assigned, cast, in branches and conditions, taken apart.

// case: declared_type
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d: Real = b.position - a.position;
//~               ^^^^^^^^^^^^^^^^^^^^^^^ declared as `Real`
//~ ERROR expected `Real`, found `Vec3`
    k * d
}

// case: rotation_without_into_inner
#[energy]
pub fn spring(a: Rigid, k: Real) -> Real {
    let m: Mat3 = a.orientation.to_rotation_matrix();
//~               ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ declared as `Mat3`
//~ ERROR expected `Mat3`, found a rotation
//~ HELP write `q.to_rotation_matrix().into_inner()`
    k * m.trace()
}

// case: assigned_wrong_type
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let mut energy = 0.0;
    energy += a.position - b.position;
//~ ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ `Real` on the left, `Vec3` on the right
//~ ERROR `+` does not take `Real` and `Vec3`
    k * energy
}

// case: array_of_two_types
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let v = [k, a.position];
//~             ^^^^^^^^^^ the first element is `Real`
//~ ERROR expected `Real`, found `Vec3`
    v[0] * b.position.x
}

// case: real_and_integer
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    2 * k * d.norm_squared()
//~ ^ the other operand is `Real`
//~ ERROR expected `Real`, found an integer
//~ HELP write `2.0`
}

// case: cast_of_real
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let n = k as usize;
//~         ^^^^^^^^^^ `as` turns an integer into a `Real`
//~ ERROR `Real` does not become an integer by `as`
//~ HELP integers are known while compiling; a kernel has reals
    a.position[n] * b.position.x
}

// case: casts
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    let n = k as i32;
//~         ^^^^^^^^ `as` turns an integer into a `Real`
//~ ERROR `Real` does not become an integer by `as`
//~ HELP integers are known while compiling; a kernel has reals
    let push = (k > 0.0) as Real;
//~            ^^^^^^^^^^^^^^^^^ `as` turns an integer into a `Real`
//~ ERROR `bool` does not become `Real` by `as`
//~ HELP write `if condition { 1.0 } else { 0.0 }`
    let x = p.position as Real;
//~         ^^^^^^^^^^^^^^^^^^ `as` turns an integer into a `Real`
//~ ERROR `Vec3` does not become `Real` by `as`
//~ HELP take an entry, `v.x`, or the length, `v.norm()`
    push * x
}

// case: branches_of_different_types
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = if k > 0.0 { b.position - a.position } else { 0.0 };
//~         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ `Vec3` and `Real`
//~ ERROR the branches have different types
    d.norm_squared()
}

// case: if_without_else
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = a.position.dot(&b.position);
    let s = if d < 0.0 { k };
//~         ^^^^^^^^^^^^^^^^ its branch is `Real`
//~ ERROR an `if` without `else` has no value
//~ HELP add an `else` branch, or assign within the branch
    s * d
}

// case: condition_is_no_comparison
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    if d.norm_squared() { k } else { 0.0 }
//~    ^^^^^^^^^^^^^^^^ a condition is a comparison, or several joined by `&&` and `||`
//~ ERROR expected `bool`, found `Real`
}

// case: not_of_real
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    if !k { 1.0 } else { a.position.dot(&b.position) }
//~    ^^ not a condition
//~ ERROR `!` does not take `Real`
//~ HELP for the opposite number write `-x`
}

// case: pattern_of_wrong_length
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let (x, y) = (k, a.position.x, b.position.x);
//~     ^^^^^^ the value is `(Real, Real, Real)`
//~ ERROR a pattern of 2 for 3 values
    x * y
}

// case: pattern_on_vector
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let (x, y, z) = b.position - a.position;
//~     ^^^^^^^^^ this binds parts
//~ ERROR `Vec3` has no parts to bind
//~ HELP take its entries by `.x`, `.y`, `.z`
    k * (x + y + z)
}

// case: wrench_without_torque
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let w = Wrench { force: b.position - a.position };
//~         ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ both of its fields have to be given
//~ ERROR a wrench without `torque`
//~ HELP write `Wrench { force, torque }`; `Vec3::zeros()` where there is none
    k * w.force.norm_squared()
}
