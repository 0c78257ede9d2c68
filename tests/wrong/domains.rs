//! The attribute `#[domain(…)]`.

// case: domain_malformed
#[constraint]
#[domain(rest: 0.1..2.0)]
//~          ^ expected `=`
//~ ERROR a domain is malformed
//~ HELP write `#[domain(length = 0.1..2.0, axis = unit)]`
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_not_a_range
#[constraint]
#[domain(rest = 2.0)]
//~             ^^^ this is neither
//~ ERROR a domain is a range or `unit`
//~ HELP write `#[domain(length = 0.1..2.0, axis = unit)]`
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_without_end
#[constraint]
#[domain(rest = 0.1..)]
//~                ^^ one of them is missing
//~ ERROR a domain has two ends
//~ HELP write `#[domain(length = 0.1..2.0, axis = unit)]`
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_empty
#[constraint]
#[domain(rest = 2.0..0.1)]
//~      ^^^^^^^^^^^^^^^ 2 is above 0.1
//~ ERROR an empty range
//~ HELP write the smaller end first
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_integer
#[constraint]
#[domain(rest = 0..2)]
//~             ^ an end of a range is `Real`
//~ ERROR expected `Real`, found an integer
//~ HELP write `0.0`
//~                ^ an end of a range is `Real`
//~ ERROR expected `Real`, found an integer
//~ HELP write `2.0`
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_unit_real
#[constraint]
#[domain(rest = unit)]
//~      ^^^^^^^^^^^ neither a vector nor a quaternion
//~ ERROR `rest` cannot be a unit vector
//~ HELP state a range, as in `0.1..2.0`
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_unknown_parameter
#[constraint]
#[domain(rst = 0.1..2.0)]
//~      ^^^ no parameter of `plane`
//~ ERROR unknown parameter `rst`
//~ HELP did you mean `rest`?
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_of_helper
#[domain(x = 0.0..1.0)]
//~ 1-23 `square` is a helper
//~ ERROR a domain belongs to a force function
//~ HELP state the domain of the force function's own parameters
fn square(x: Real) -> Real {
    x * x
}

#[energy]
pub fn well(a: Particle) -> Real {
    square(a.position.x)
}

// case: domain_of_body
#[constraint]
#[domain(a = 0.0..1.0)]
//~      ^ no parameter of `plane`
//~ ERROR unknown parameter `a`
//~ HELP state the range of a field, as in `a.position = -1.0..1.0`
pub fn plane(a: Particle, rest: Real, axis: Vec3) -> Real {
    a.position.dot(&axis) - rest
}

// case: domain_of_body_unknown_field
#[energy]
#[domain(a.place = -1.0..1.0)]
//~        ^^^^^ no field of this body
//~ ERROR `place` has no range
//~ HELP its fields are `position`, `velocity`, `angular_velocity`
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}

// case: domain_of_unknown_body
#[energy]
#[domain(k.position = -1.0..1.0)]
//~      ^ no body of `well`
//~ ERROR unknown body `k`
//~ HELP a range holds for every entry of a parameter: write `k = …`
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}

// case: domain_of_field_unit
#[energy]
#[domain(a.velocity = unit)]
//~      ^^^^^^^^^^^^^^^^^ this is none
//~ ERROR the domain of a field is a range
//~ HELP write `a.velocity = -1.0..1.0`
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}

// case: domain_of_orientation
#[energy]
#[domain(a.orientation = -1.0..1.0)]
//~        ^^^^^^^^^^^ a quaternion of length one
//~ ERROR `orientation` has no range
//~ HELP leave the clause out
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}

// case: domain_length_negative
#[energy]
#[domain(length = -1e-3)]
//~      ^^^^^^^^^^^^^^ -0.001 is no length
//~ ERROR the scale of the bodies is not positive
//~ HELP write the length that bodies are apart by, as in `length = 1e-3`
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}

// case: domain_length_range
#[energy]
#[domain(length = 1e-3..1e-2)]
//~      ^^^^^^ no parameter of `well`
//~ ERROR unknown parameter `length`
//~ HELP the scale of all bodies is one number, as in `length = 1e-3`
pub fn well(a: Rigid, k: Real) -> Real {
    k * a.position.norm_squared()
}

// case: domain_length_of_parameter
#[energy]
#[domain(length = 1e-3)]
//~      ^^^^^^^^^^^^^ `length` is a parameter here, so that this is not the scale of all bodies
//~ ERROR one number is no domain of a parameter
//~ HELP write a range; for the scale, state `BODY.position = -1.0..1.0` of each body
pub fn well(a: Rigid, length: Real) -> Real {
    a.position.norm_squared() / length
}
