// stages: c, rust
// layout: accumulate, 1
/// Two functions: one with long names, one that chooses.
#[energy]
fn long_names(the_first_of_two_bodies: Particle, the_second_of_two_bodies: Particle, stiffness_of_it: Real) -> Real {
    let it = the_first_of_two_bodies.position - the_second_of_two_bodies.position;
    if it.x > 0.0 { stiffness_of_it * it.norm_squared() } else { -stiffness_of_it * it.z }
}
