//! Calls with a wrong number of arguments, or with arguments of a wrong type.

// case: wrong_number_of_arguments
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    k * d.dot()
//~     ^^^^^^^ 0 given
//~ ERROR `dot` takes 1 argument, not 0
//~ HELP write `.dot(Vec3)`
}

// case: wrong_number_of_arguments_of_helper
fn square(x: Real) -> Real {
    x * x
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * square(a.position.x, b.position.x)
//~     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ 2 given
//~ ERROR `square` takes 1 argument, not 2
//~ HELP write `square(x)`
}

// case: arity_of_methods
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k.atan2() + k.max(1.0, 2.0) + p.position.norm(2) + k.powi() + Vec3::new(1.0, 2.0).x
//~ ^^^^^^^^^ 0 given
//~ ERROR `atan2` takes 1 argument, not 0
//~ HELP write `.atan2(Real)`
//~             ^^^^^^^^^^^^^^^ 2 given
//~ ERROR `max` takes 1 argument, not 2
//~ HELP write `.max(Real)`
//~                               ^^^^^^^^^^^^^^^^^^ 1 given
//~ ERROR `norm` takes 0 arguments, not 1
//~ HELP write `.norm()`
//~                                                    ^^^^^^^^ 0 given
//~ ERROR `powi` takes 1 argument, not 0
//~ HELP write `.powi(i32)`
//~                                                               ^^^^^^^^^^^^^^^^^^^ 2 given
//~ ERROR `new` takes 3 arguments, not 2
//~ HELP write `Vec3::new(Real, Real, Real)`
}

// case: helper_called_with_wrong_type
fn square(x: Real) -> Real {
    x * x
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * square(a.position - b.position)
//~            ^^^^^^^^^^^^^^^^^^^^^^^ `x` of `square` is `Real`
//~ ERROR expected `Real`, found `Vec3`
}

// case: integer_for_real
fn energy(k: Real, d: Vec3) -> Real {
    k * d.norm_squared()
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    energy(2, b.position - a.position) * k
//~        ^ `k` of `energy` is `Real`
//~ ERROR expected `Real`, found an integer
//~ HELP write `2.0`
}

// case: real_for_integer
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b.position - a.position).norm().powi(2.0)
//~                                           ^^^ `powi` takes an integer here
//~ ERROR expected an integer, found `Real`
//~ HELP write the number without a point, or use `powf` for a real power
}

// case: vectors_of_different_length
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    k * d.dot(&Vec2::new(1.0, 2.0))
//~            ^^^^^^^^^^^^^^^^^^^ `dot` takes `Vec3` here
//~ ERROR expected `Vec3`, found `Vec2`
}
