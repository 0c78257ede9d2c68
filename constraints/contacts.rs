//! Contacts: of points and spheres with a plane, and of spheres with each other.
//!
//! Without friction a contact is a one-sided constraint, its row the gap. With friction it is a force: a
//! one-sided spring and damper along the normal, and Coulomb friction made smooth so that it has a derivative
//! at rest,
//!
//! ```text
//! friction = −μ · load · v / √(|v|² + ε²),    v the sliding velocity, ε the slip speed.
//! ```
//!
//! Bodies at rest on a slope creep at a speed below ε; choose it small against the speeds that matter.
//! A plane is a point of it, `origin`, and its unit normal, which points out of the solid.

use forcec_runtime::prelude::*;

/// Contact of a particle with a plane.
///
/// C = n·(x − origin).
///
/// `origin`: a point of the plane, m. `normal`: n.
#[constraint(unilateral)]
#[domain(normal = unit)]
pub fn particle_plane(p: Particle, origin: Vec3, normal: Vec3) -> Real {
    normal.dot(&(p.position - origin))
}

/// Contact of a point of `a`, a corner of a box for example, with a plane.
///
/// C = n·(x + q·arm − origin).
///
/// `arm`: the point in body space, m. `origin`: a point of the plane, m. `normal`: n.
#[constraint(unilateral)]
#[domain(normal = unit)]
pub fn point_plane(a: Rigid, arm: Vec3, origin: Vec3, normal: Vec3) -> Real {
    normal.dot(&((a.position - origin) + a.orientation * arm))
}

/// Contact of a sphere with a plane.
///
/// C = n·(x − origin) − radius.
///
/// `radius`: m. `origin`: a point of the plane, m. `normal`: n.
#[constraint(unilateral)]
#[domain(radius = 0.05..1.0, normal = unit)]
pub fn sphere_plane(a: Rigid, radius: Real, origin: Vec3, normal: Vec3) -> Real {
    normal.dot(&(a.position - origin)) - radius
}

/// Contact of two spheres.
///
/// C = |xb − xa| − (radius_a + radius_b).
///
/// `radius_a`, `radius_b`: m.
#[constraint(unilateral)]
#[domain(radius_a = 0.05..1.0, radius_b = 0.05..1.0)]
pub fn sphere_sphere(a: Rigid, b: Rigid, radius_a: Real, radius_b: Real) -> Real {
    (b.position - a.position).norm() - (radius_a + radius_b)
}

/// Elastic contact of two spheres, whose force grows with the power 3/2 of the overlap.
///
/// E = 8/15 · E* · √R · d^(5/2) with overlap d = radius_a + radius_b − |xb − xa| and
/// 1/R = 1/radius_a + 1/radius_b. Hertz, "Über die Berührung fester elastischer Körper", 1882.
///
/// `radius_a`, `radius_b`: m. `modulus`: E*, the effective modulus of the pair, Pa.
#[energy]
#[domain(radius_a = 0.05..1.0, radius_b = 0.05..1.0, modulus = 1e4..1e8)]
pub fn hertz_contact(a: Rigid, b: Rigid, radius_a: Real, radius_b: Real, modulus: Real) -> Real {
    let overlap = radius_a + radius_b - (b.position - a.position).norm();
    let radius = radius_a * radius_b / (radius_a + radius_b);
    if overlap > 0.0 {
        8.0 / 15.0 * modulus * radius.sqrt() * overlap * overlap * overlap.sqrt()
    } else {
        0.0
    }
}

/// Contact of a particle with a plane, with smooth Coulomb friction.
///
/// F = load · (n − μ · v / √(|v|² + ε²)), v the velocity along the plane.
///
/// `origin`: a point of the plane, m. `normal`: n. `stiffness`: N/m. `damping`: N·s/m. `friction`: μ.
/// `slip_speed`: ε, m/s.
#[force]
#[domain(
    normal = unit,
    stiffness = 1e2..1e6,
    damping = 0.0..1e3,
    friction = 0.0..1.5,
    slip_speed = 1e-4..1e-1
)]
pub fn particle_plane_friction(
    p: Particle,
    origin: Vec3,
    normal: Vec3,
    stiffness: Real,
    damping: Real,
    friction: Real,
    slip_speed: Real,
) -> Vec3 {
    let gap = normal.dot(&(p.position - origin));
    let load = contact_load(gap, normal.dot(&p.velocity), stiffness, damping);
    contact_force(load, normal, p.velocity, friction, slip_speed)
}

/// Contact of a point of `a` with a plane, with smooth Coulomb friction.
///
/// F = load · (n − μ · v / √(|v|² + ε²)) at r = q·arm, v its velocity along the plane; torque r × F.
///
/// `arm`: the point in body space, m. `origin`: a point of the plane, m. `normal`: n. `stiffness`: N/m.
/// `damping`: N·s/m. `friction`: μ. `slip_speed`: ε, m/s.
#[force]
#[domain(
    normal = unit,
    stiffness = 1e2..1e6,
    damping = 0.0..1e3,
    friction = 0.0..1.5,
    slip_speed = 1e-4..1e-1
)]
pub fn point_plane_friction(
    a: Rigid,
    arm: Vec3,
    origin: Vec3,
    normal: Vec3,
    stiffness: Real,
    damping: Real,
    friction: Real,
    slip_speed: Real,
) -> Wrench {
    let r = a.orientation * arm;
    let gap = normal.dot(&((a.position - origin) + r));
    let velocity = a.velocity + a.angular_velocity.cross(&r);
    let load = contact_load(gap, normal.dot(&velocity), stiffness, damping);
    let force = contact_force(load, normal, velocity, friction, slip_speed);
    Wrench { force, torque: r.cross(&force) }
}

/// Contact of a sphere with a plane, with smooth Coulomb friction, under which it comes to roll.
///
/// F = load · (n − μ · v / √(|v|² + ε²)) at r = −radius · n, v the velocity there along the plane;
/// torque r × F.
///
/// `radius`: m. `origin`: a point of the plane, m. `normal`: n. `stiffness`: N/m. `damping`: N·s/m.
/// `friction`: μ. `slip_speed`: ε, m/s.
#[force]
#[domain(
    radius = 0.05..1.0,
    normal = unit,
    stiffness = 1e2..1e6,
    damping = 0.0..1e3,
    friction = 0.0..1.5,
    slip_speed = 1e-4..1e-1
)]
pub fn sphere_plane_friction(
    a: Rigid,
    radius: Real,
    origin: Vec3,
    normal: Vec3,
    stiffness: Real,
    damping: Real,
    friction: Real,
    slip_speed: Real,
) -> Wrench {
    let r = normal * -radius;
    let gap = normal.dot(&(a.position - origin)) - radius;
    let velocity = a.velocity + a.angular_velocity.cross(&r);
    let load = contact_load(gap, normal.dot(&a.velocity), stiffness, damping);
    let force = contact_force(load, normal, velocity, friction, slip_speed);
    Wrench { force, torque: r.cross(&force) }
}

/// Contact of two spheres, with smooth Coulomb friction.
///
/// F = load · (n − μ · v / √(|v|² + ε²)) on `b` and −F on `a`, n = (xb − xa)/|xb − xa|, v the velocity of `b`
/// against `a` across n. Both forces act in the middle of the overlap, so that their torques balance exactly.
///
/// `radius_a`, `radius_b`: m. `stiffness`: N/m. `damping`: N·s/m. `friction`: μ. `slip_speed`: ε, m/s.
#[force]
#[domain(
    radius_a = 0.05..1.0,
    radius_b = 0.05..1.0,
    stiffness = 1e2..1e6,
    damping = 0.0..1e3,
    friction = 0.0..1.5,
    slip_speed = 1e-4..1e-1
)]
pub fn sphere_sphere_friction(
    a: Rigid,
    b: Rigid,
    radius_a: Real,
    radius_b: Real,
    stiffness: Real,
    damping: Real,
    friction: Real,
    slip_speed: Real,
) -> (Wrench, Wrench) {
    let between = b.position - a.position;
    let length = between.norm();
    let normal = between / length;
    let gap = length - (radius_a + radius_b);
    let ra = normal * (radius_a + 0.5 * gap);
    let rb = normal * -(radius_b + 0.5 * gap);
    let velocity =
        (b.velocity - a.velocity) + (b.angular_velocity.cross(&rb) - a.angular_velocity.cross(&ra));
    let load = contact_load(gap, normal.dot(&velocity), stiffness, damping);
    let force = contact_force(load, normal, velocity, friction, slip_speed);
    (Wrench { force: -force, torque: -ra.cross(&force) }, Wrench { force, torque: rb.cross(&force) })
}

/// The load along the normal: a spring and a damper that push only, and only while the gap is negative.
fn contact_load(gap: Real, gap_rate: Real, stiffness: Real, damping: Real) -> Real {
    if gap < 0.0 { (-stiffness * gap - damping * gap_rate).max(0.0) } else { 0.0 }
}

/// The load along the normal together with the friction against the velocity across it.
fn contact_force(load: Real, normal: Vec3, velocity: Vec3, friction: Real, slip_speed: Real) -> Vec3 {
    let sliding = velocity - normal * normal.dot(&velocity);
    let speed = (sliding.norm_squared() + slip_speed * slip_speed).sqrt();
    load * (normal - sliding * (friction / speed))
}
