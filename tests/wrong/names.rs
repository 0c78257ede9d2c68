//! Names that are neither bound, nor defined, nor known to a type.

// case: unknown_name
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let delta = b.position - a.position;
    k * detla.norm_squared()
//~     ^^^^^ not bound here, and not a constant
//~ ERROR unknown name `detla`
//~ HELP did you mean `delta`?
}

// case: unknown_constant_of_std
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b.position - a.position).norm_squared() * FRAC_PI_2
//~                                                ^^^^^^^^^ not bound here, and not a constant
//~ ERROR unknown name `FRAC_PI_2`
//~ HELP write `PI / 2.0`
}

// case: limits_of_floats
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    k.min(f64::MAX) + Real::EPSILON + f64::INFINITY * p.position.x
//~       ^^^^^^^^ not bound here, and not a constant
//~ ERROR unknown name `MAX`
//~ HELP write the number that is meant
//~                   ^^^^^^^^^^^^^ not bound here, and not a constant
//~ ERROR unknown name `EPSILON`
//~ HELP write the number that is meant
//~                                   ^^^^^^^^^^^^^ not bound here, and not a constant
//~ ERROR unknown name `INFINITY`
//~ HELP write the number that is meant
}

// case: assigned_without_let
#[energy]
pub fn f(p: Particle, k: Real) -> Real {
    energy = k * p.position.x;
//~ ^^^^^^ not bound here, and not a constant
//~ ERROR unknown name `energy`
//~ HELP to bind it write `let energy = …;`
    energy
//~ ^^^^^^ not bound here, and not a constant
//~ ERROR unknown name `energy`
}

// case: mistake_in_unused_helper
fn area(a: Vec3, b: Vec3) -> Real {
    0.5 * a.cros(&b).norm()
//~         ^^^^ no such method on `Vec3`
//~ ERROR unknown method `cros`
//~ HELP did you mean `cross`?
}

// case: mistake_in_helper_called_often
fn square(x: Real) -> Real {
    x * y
//~     ^ not bound here, and not a constant
//~ ERROR unknown name `y`
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let p = a.position;
    k * (square(p.x) + square(p.y) + square(b.position.z))
}

// case: unknown_function
fn strech(d: Vec3) -> Real {
    d.norm_squared()
}

#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    stretch(b.position - a.position) * k
//~ ^^^^^^^ no function of this file has this name
//~ ERROR unknown function `stretch`
//~ HELP did you mean `strech`?
}

// case: function_that_is_a_method
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * sqrt((b.position - a.position).norm_squared() + 1.0)
//~     ^^^^ no function of this file has this name
//~ ERROR unknown function `sqrt`
//~ HELP `sqrt` is a method; write `x.sqrt()`
}

// case: type_as_function
#[force]
pub fn wind(p: Particle, speed: Real) -> Vec3 {
    vec3(speed, 0.0, 0.0) - p.velocity
//~ ^^^^ no function of this file has this name
//~ ERROR unknown function `vec3`
//~ HELP write `Vec3::new(…)`
}

// case: unknown_associated_function
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * Vec3::x_axis().dot(&(b.position - a.position))
//~     ^^^^^^^^^^^^ no such function of `Vec3`
//~ ERROR unknown function `Vec3::x_axis`
//~ HELP write `Vec3::x()`
}

// case: unknown_method
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.position - a.position;
    0.5 * k * d.nrom().powi(2)
//~             ^^^^ no such method on `Vec3`
//~ ERROR unknown method `nrom`
//~ HELP did you mean `norm`?
}

// case: integer_method
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * 2.powi(3) * (b.position - a.position).norm_squared()
//~       ^^^^ no such method on an integer
//~ ERROR unknown method `powi`
//~ HELP write `2.0`
}

// case: field_called_as_method
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b.position() - a.position).norm_squared()
//~        ^^^^^^^^ no such method on `Particle`
//~ ERROR unknown method `position`
//~ HELP `position` is a field; write it without `()`
}

// case: method_without_call
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    k * (b.position - a.position).norm_squared
//~                               ^^^^^^^^^^^^ no such field on `Vec3`
//~ ERROR unknown field `norm_squared`
//~ HELP `norm_squared` is a method; write `.norm_squared()`
}

// case: unknown_field
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let d = b.positon - a.position;
//~           ^^^^^^^ no such field on `Particle`
//~ ERROR unknown field `positon`
//~ HELP did you mean `position`?
    k * d.norm_squared()
}

// case: fields_of_other_engines
#[energy]
pub fn f(a: Rigid, p: Particle) -> Real {
    a.pos.x + a.rotation.w + a.omega.x + a.mass + p.rotation.w
//~   ^^^ no such field on `Rigid`
//~ ERROR unknown field `pos`
//~ HELP write `.position`
//~             ^^^^^^^^ no such field on `Rigid`
//~ ERROR unknown field `rotation`
//~ HELP write `.orientation`
//~                            ^^^^^ no such field on `Rigid`
//~ ERROR unknown field `omega`
//~ HELP write `.angular_velocity`
//~                                        ^^^^ no such field on `Rigid`
//~ ERROR unknown field `mass`
//~ HELP take it as a parameter
//~                                                 ^^^^^^^^ no such field on `Particle`
//~ ERROR unknown field `rotation`
//~ HELP `Particle` has no orientation, a `Rigid` has
}

// case: quaternion_part
#[energy]
pub fn spring(a: Rigid, k: Real) -> Real {
    k * a.orientation.x
//~                   ^ no such field on `Quat`
//~ ERROR unknown field `x`
//~ HELP the parts of a quaternion are `i`, `j`, `k` and `w`; write `.i`
}

// case: element_of_tuple
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let pair = (k, a.position - b.position);
    pair.2
//~      ^ no such field on `(Real, Vec3)`
//~ ERROR unknown field `2`
//~ HELP the tuple has 2 elements, counted from 0
}

// case: wrench_unknown_field
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let w = Wrench { force: b.position, moment: a.position };
//~                                     ^^^^^^ no such field on `Wrench`
//~ ERROR unknown field `moment`
//~ HELP its fields are `force` and `torque`
    k * w.force.x
}

// case: unknown_struct
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real) -> Real {
    let w = Wrensh { force: b.position, torque: a.position };
//~         ^^^^^^ no struct of this name
//~ ERROR unknown struct `Wrensh`
//~ HELP did you mean `Wrench`?
    k * w.force.x
}

// case: unknown_type
#[energy]
pub fn spring(a: Particle, b: Particle, k: Real, w: Vec5) -> Real {
//~                                                 ^^^^ no type of the force language
//~ ERROR unknown type `Vec5`
//~ HELP did you mean `Vec2`?
    k * (b.position - a.position).norm_squared() * w.x
}

// case: type_of_nalgebra
#[energy]
pub fn spring(a: Particle, b: Particle, k: f64, w: Vector3<f64>) -> Real {
//~                                                ^^^^^^^^^^^^ a generic type
//~ ERROR `Vector3` goes by another name here
//~ HELP write `Vec3`
    k * w.dot(&b.position) * a.position.x
}
