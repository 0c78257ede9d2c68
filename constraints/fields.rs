//! Fields: gravity, media that resist or carry, and the torque of a body's own spin.

use forcec_runtime::prelude::*;

/// Below this speed, m/s, quadratic drag turns linear, so that it has a derivative at rest.
const SLOW: Real = 1e-6;

/// Uniform gravity on a rigid body.
///
/// E = −m g·x.
///
/// `mass`: kg. `acceleration`: g, m/s².
#[energy]
#[domain(mass = 0.01..100.0, acceleration = -10.0..10.0)]
pub fn gravity(a: Rigid, mass: Real, acceleration: Vec3) -> Real {
    -mass * acceleration.dot(&a.position)
}

/// Uniform gravity on a particle.
///
/// E = −m g·x.
///
/// `mass`: kg. `acceleration`: g, m/s².
#[energy]
#[domain(mass = 0.01..100.0, acceleration = -10.0..10.0)]
pub fn particle_gravity(p: Particle, mass: Real, acceleration: Vec3) -> Real {
    -mass * acceleration.dot(&p.position)
}

/// Gravity between two particles, softened so that it stays finite when they meet.
///
/// E = −G ma mb / √(|xb − xa|² + softening²). Plummer, "On the problem of distribution in globular star
/// clusters", 1911.
///
/// `constant`: G, m³/(kg·s²). `mass_a`, `mass_b`: kg. `softening`: m.
#[energy]
#[domain(constant = 0.1..10.0, mass_a = 0.1..10.0, mass_b = 0.1..10.0, softening = 1e-3..0.5)]
pub fn pair_gravity(
    a: Particle,
    b: Particle,
    constant: Real,
    mass_a: Real,
    mass_b: Real,
    softening: Real,
) -> Real {
    let between = b.position - a.position;
    -constant * mass_a * mass_b / (between.norm_squared() + softening * softening).sqrt()
}

/// Quadratic drag of a medium on a rigid body: a force through its centre, and no torque.
///
/// F = −½ ρ · drag_area · |u| u, u = v − wind.
///
/// `wind`: velocity of the medium, m/s. `density`: ρ, kg/m³. `drag_area`: drag coefficient times area, m².
#[force]
#[domain(wind = -20.0..20.0, density = 0.1..1000.0, drag_area = 1e-3..1.0)]
pub fn drag(a: Rigid, wind: Vec3, density: Real, drag_area: Real) -> Wrench {
    Wrench { force: quadratic_drag(a.velocity - wind, density, drag_area), torque: Vec3::zeros() }
}

/// Quadratic drag of a medium on a particle.
///
/// F = −½ ρ · drag_area · |u| u, u = v − wind.
///
/// `wind`: velocity of the medium, m/s. `density`: ρ, kg/m³. `drag_area`: drag coefficient times area, m².
#[force]
#[domain(wind = -20.0..20.0, density = 0.1..1000.0, drag_area = 1e-3..1.0)]
pub fn particle_drag(p: Particle, wind: Vec3, density: Real, drag_area: Real) -> Vec3 {
    quadratic_drag(p.velocity - wind, density, drag_area)
}

/// Drag of a viscous medium on a slow sphere, which also brakes its spin.
///
/// F = −6π η r (v − flow), torque −8π η r³ ω. Stokes, "On the effect of the internal friction of fluids on
/// the motion of pendulums", 1851; the torque is Kirchhoff's, "Vorlesungen über mathematische Physik", 1876.
///
/// `flow`: velocity of the medium, m/s. `viscosity`: η, Pa·s. `radius`: r, m.
#[force]
#[domain(flow = -1.0..1.0, viscosity = 1e-3..10.0, radius = 1e-3..0.1)]
pub fn stokes_drag(a: Rigid, flow: Vec3, viscosity: Real, radius: Real) -> Wrench {
    let scale = PI * viscosity * radius;
    let force = (flow - a.velocity) * (6.0 * scale);
    let torque = a.angular_velocity * (-8.0 * scale * radius * radius);
    Wrench { force, torque }
}

/// Wind on a triangle of cloth: it is pushed along its normal, and each corner takes a third.
///
/// F = ρ/4 · drag_coefficient · (u·n) |u·n| / |n|² · n / 3 with n = (x1 − x0) × (x2 − x0), twice the area,
/// and u the wind against the mean velocity of the corners.
///
/// `wind`: velocity of the air, m/s. `density`: ρ, kg/m³. `drag_coefficient`: about 1 to 2 for a plate.
#[force]
#[domain(wind = -20.0..20.0, density = 0.5..2.0, drag_coefficient = 0.5..2.0)]
pub fn triangle_wind(
    p0: Particle,
    p1: Particle,
    p2: Particle,
    wind: Vec3,
    density: Real,
    drag_coefficient: Real,
) -> (Vec3, Vec3, Vec3) {
    let normal = (p1.position - p0.position).cross(&(p2.position - p0.position));
    let relative = wind - (p0.velocity + p1.velocity + p2.velocity) / 3.0;
    let flux = relative.dot(&normal);
    let share = normal * (density * drag_coefficient / 12.0 * flux * flux.abs() / normal.norm_squared());
    (share, share, share)
}

/// Buoyancy of a sphere that floats or is submerged, at its centre.
///
/// F = ρ · strength · V · up, V = π h² (radius − h/3) the volume of the cap below the surface, of height
/// h = clamp(up·(surface − x) + radius, 0, 2 radius).
///
/// `radius`: m. `density`: ρ of the liquid, kg/m³. `strength`: of gravity, m/s². `surface`: a point of the
/// surface, m. `up`: its normal.
#[force]
#[domain(radius = 0.05..1.0, density = 500.0..2000.0, strength = 1.0..20.0, up = unit)]
pub fn buoyancy(a: Rigid, radius: Real, density: Real, strength: Real, surface: Vec3, up: Vec3) -> Wrench {
    let depth = up.dot(&(surface - a.position)) + radius;
    let height = depth.clamp(0.0, 2.0 * radius);
    let submerged = PI * height * height * (radius - height / 3.0);
    Wrench { force: up * (density * strength * submerged), torque: Vec3::zeros() }
}

/// Gyroscopic torque: the spin's share in Euler's equations, for integrators that want it among the forces.
///
/// torque = −ω × I ω, I ω = q·(inertia ∘ (q⁻¹·ω)).
///
/// `inertia`: principal moments; the axes of the body are the principal axes, kg·m².
#[force]
#[domain(inertia = 0.01..10.0)]
pub fn gyroscopic_torque(a: Rigid, inertia: Vec3) -> Wrench {
    let spin = a.orientation.conjugate() * a.angular_velocity;
    let momentum = a.orientation * inertia.component_mul(&spin);
    Wrench { force: Vec3::zeros(), torque: momentum.cross(&a.angular_velocity) }
}

/// −½ ρ · drag_area · |u| u, with √(|u|² + SLOW²) in place of |u|.
fn quadratic_drag(relative: Vec3, density: Real, drag_area: Real) -> Vec3 {
    let speed = (relative.norm_squared() + SLOW * SLOW).sqrt();
    relative * (-0.5 * density * drag_area * speed)
}
