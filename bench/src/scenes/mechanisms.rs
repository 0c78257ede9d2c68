//! Mechanisms of rigid joints with published solutions, most of them with loops.
//!
//! Coordinates are those of the sources: plane mechanisms are in the plane of x and y, and gravity is along −y.

use super::{GRAVITY, ROD, Scene, box_inertia};
use forcec_constraints::joints::{distance, hinge};
use forcec_constraints::springs::spring;
use forcec_runtime::prelude::{Quat, Rigid, Vec3, Wrench};
use forcec_runtime::{Body, Integrator, Law, Motion};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Half the sides of the rods of 1 m, for drawing; those of Bricard's mechanism have this section.
const BAR: [f64; 3] = [0.5, 0.05, 0.05];

/// A scene with gravity along −y, stepped by `RungeKutta4` at its own step.
fn scene(time: f64, step: f64) -> Scene {
    let mut scene = Scene::new(time, step);
    scene.world.gravity = Vec3::new(0.0, -GRAVITY, 0.0);
    scene.world.settings.integrator = Integrator::RungeKutta4;
    scene.world.settings.tolerance = f64::INFINITY;
    scene
}

/// A pose in the plane: place, m, and angle, rad.
fn plane(x: f64, y: f64, angle: f64) -> Rigid {
    let orientation = Quat::from_axis_angle(&Vec3::z_axis(), angle);
    Rigid { position: Vec3::new(x, y, 0.0), orientation, ..Rigid::default() }
}

/// Joins two bodies by a rigid hinge, where the world has `at`, m, and `axis`.
fn hinged(scene: &mut Scene, bodies: [Body; 2], at: Vec3, axis: Vec3) {
    let [a, b] = bodies.map(|body| scene.world.rigid(body).expect("a rigid body of the scene"));
    let normal = if axis.x.abs() < 0.5 { axis.cross(&Vec3::x()) } else { axis.cross(&Vec3::y()) };
    let seen = |body: &Rigid, direction: Vec3| body.orientation.inverse_transform_vector(&direction).into();
    let params = hinge::Params {
        arm_a: seen(&a, at - a.position),
        arm_b: seen(&b, at - b.position),
        axis_a: seen(&a, axis),
        normal_b1: seen(&b, normal),
        normal_b2: seen(&b, axis.cross(&normal)),
        stiffness: 0.0,
        damping: 0.0,
    };
    scene.world.add_constraint(Law::Rigid, params, bodies).expect("a joint of two bodies");
}

/// A point mass of 1 kg on a massless rod of 1 m, from (−1, 0) at rest.
pub fn pendulum() -> Scene {
    let mut scene = scene(10.0, 1e-2);
    let pin = scene.particle(Vec3::zeros(), Motion::Kinematic);
    let mass = scene.particle(Vec3::new(-1.0, 0.0, 0.0), Motion::Dynamic(1.0, Vec3::zeros()));
    let params = spring::Params { rest_length: 1.0, stiffness: 0.0, damping: 0.0 };
    scene.world.add_constraint(Law::Rigid, params, [pin, mass]).expect("a rod of two particles");
    scene
}

/// A row of `windows` four-bar linkages of rods of 1 m and 1 kg; the upper rods move at 1 m/s along x.
///
/// Upright rods are even, level ones odd.
pub fn four_bars(windows: usize) -> Scene {
    let mut scene = scene(10.0, 1e-2);
    // Only the moment about z matters.
    let moments = Vec3::repeat(1.0 / 12.0);
    let mut upright = None;
    for k in 0..=windows {
        let x = k as f64;
        let top = Vec3::new(x, 1.0, 0.0);
        let level = upright.map(|last| {
            let state = Rigid { velocity: Vec3::x(), ..plane(x - 0.5, 1.0, 0.0) };
            let body = scene.rigid(state, 1.0, moments, BAR);
            hinged(&mut scene, [last, body], top - Vec3::x(), Vec3::z());
            body
        });
        let pin = scene.pin(Vec3::new(x, 0.0, 0.0));
        let state =
            Rigid { velocity: 0.5 * Vec3::x(), angular_velocity: -Vec3::z(), ..plane(x, 0.5, FRAC_PI_2) };
        let body = scene.rigid(state, 1.0, moments, BAR);
        hinged(&mut scene, [pin, body], Vec3::new(x, 0.0, 0.0), Vec3::z());
        if let Some(level) = level {
            hinged(&mut scene, [body, level], top, Vec3::z());
        }
        upright = Some(body);
    }
    scene
}

/// Bricard's mechanism: five rods of 1 m, 1 kg and 0.1 × 0.1 m along edges of a cube, and six hinges; the sixth
/// side is the ground. Gruebler's formula counts no degree of freedom, and the mechanism has one.
pub fn bricard() -> Scene {
    let mut scene = scene(10.0, 1e-2);
    let corners = [[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1]];
    let corners = corners.map(|corner| Vec3::from(corner.map(f64::from)));
    let axes = [Vec3::y(), Vec3::z(), Vec3::x()];
    let ground = scene.pin(corners[0]);
    let mut last = ground;
    for k in 0..5 {
        let way = corners[k + 1] - corners[k];
        let orientation = if way.x < -0.5 {
            Quat::from_axis_angle(&Vec3::z_axis(), PI)
        } else {
            Quat::rotation_between(&Vec3::x(), &way).expect("directions that are not opposite")
        };
        let state = Rigid { position: corners[k] + 0.5 * way, orientation, ..Rigid::default() };
        let body = scene.rigid(state, 1.0, box_inertia(1.0, BAR), BAR);
        hinged(&mut scene, [last, body], corners[k], axes[k % 3]);
        last = body;
    }
    hinged(&mut scene, [last, ground], corners[5], axes[2]);
    scene
}

/// A link of the squeezing mechanism.
struct Link {
    mass: f64,
    /// About the axis of hinges, kg·m².
    moment: f64,
    /// Where the first joint is, seen from the centre of mass, m.
    first: [f64; 2],
    /// The other joints, from the first on, m.
    others: &'static [[f64; 2]],
}

/// The links K1 to K7.
const LINKS: [Link; 7] = [
    // The crank: the motor, and K2.
    Link { mass: 0.04325, moment: 2.194e-6, first: [-0.00092, 0.0], others: &[[0.007, 0.0]] },
    // K1, and the point where K3, K4 and K6 meet.
    Link { mass: 0.00365, moment: 4.410e-7, first: [0.0115, 0.0], others: &[[-0.028, 0.0]] },
    // B, that point, and the spring.
    Link {
        mass: 0.02373,
        moment: 5.255e-6,
        first: [-0.01043, 0.01874],
        others: &[[0.0, -0.035], [0.02, -0.018]],
    },
    // K5, and that point.
    Link { mass: 0.00706, moment: 5.667e-7, first: [0.0, 0.00579], others: &[[0.0, -0.02]] },
    // A, and K4.
    Link { mass: 0.07050, moment: 1.169e-5, first: [-0.02308, -0.00916], others: &[[0.04, 0.0]] },
    // K7, and that point.
    Link { mass: 0.00706, moment: 5.667e-7, first: [-0.00579, 0.0], others: &[[0.02, 0.0]] },
    // A, and K6.
    Link { mass: 0.05498, moment: 1.912e-5, first: [0.00449, 0.01228], others: &[[0.0, -0.04]] },
];

/// The torque that drives the squeezing mechanism, N·m.
pub const ANDREWS_TORQUE: Vec3 = Vec3::new(0.0, 0.0, 0.033);

/// Andrews' squeezing mechanism: seven bodies in a plane, ten hinges, a spring and a motor.
pub fn andrews() -> Scene {
    let mut scene = scene(0.03, 1e-5);
    scene.world.gravity = Vec3::zeros();
    let [a, b, c] = [[-0.06934, -0.00227], [-0.03635, 0.03273], [0.014, 0.072]];
    // β, Θ, γ, Φ, δ, Ω, ε at the start.
    let q = [
        -0.061_713_890_014_276_45,
        0.0,
        0.455_279_819_163_070_4,
        0.222_668_390_165_885_88,
        0.487_364_979_543_842_55,
        -0.222_668_390_165_885_88,
        1.230_547_444_549_821_2,
    ];
    let angles = [q[0], q[0] + q[1], q[2], q[3] + q[4], q[4], q[5] + q[6], q[6]];
    let flat = |[x, y]: [f64; 2]| Vec3::new(x, y, 0.0);
    let turned = |k: usize, arm: [f64; 2]| plane(0.0, 0.0, angles[k]).orientation * flat(arm);
    // Of each link its first joint and its second.
    let mut ends = [[Vec3::zeros(); 2]; 7];
    let mut bodies = Vec::new();
    for k in [0, 1, 2, 4, 3, 6, 5] {
        ends[k][0] = [flat([0.0; 2]), ends[0][1], flat(b), ends[4][1], flat(a), ends[6][1], flat(a)][k];
        ends[k][1] = ends[k][0] + turned(k, LINKS[k].others[0]);
    }
    for (k, link) in LINKS.iter().enumerate() {
        let centre = ends[k][0] - turned(k, link.first);
        let state = plane(centre.x, centre.y, angles[k]);
        let half = [0.5 * flat(link.others[0]).norm(), 0.002, 0.002];
        bodies.push(scene.rigid(state, link.mass, Vec3::repeat(link.moment), half));
    }
    let pins = [[0.0; 2], a, b, c].map(|pin| scene.pin(flat(pin)));
    let [k1, k2, k3, k4, k5, k6, k7] = [0, 1, 2, 3, 4, 5, 6].map(|k| bodies[k]);
    for (bodies, at) in [
        ([pins[0], k1], ends[0][0]),
        ([k1, k2], ends[0][1]),
        ([pins[2], k3], ends[2][0]),
        ([k2, k3], ends[1][1]),
        ([pins[1], k5], ends[4][0]),
        ([k5, k4], ends[4][1]),
        ([k2, k4], ends[1][1]),
        ([pins[1], k7], ends[6][0]),
        ([k7, k6], ends[6][1]),
        ([k2, k6], ends[1][1]),
    ] {
        hinged(&mut scene, bodies, at, Vec3::z());
    }
    let [first, [x, y]] = [LINKS[2].first, LINKS[2].others[1]];
    let arm_b = [first[0] + x, first[1] + y, 0.0];
    let params =
        distance::Params { arm_a: [0.0; 3], arm_b, rest_length: 0.07785, stiffness: 4530.0, damping: 0.0 };
    scene.world.add(params, [pins[3], k3]).expect("a spring of two bodies");
    let load = Wrench { force: Vec3::zeros(), torque: ANDREWS_TORQUE };
    scene.world.set_load(k1, load).expect("a body of the scene");
    scene
}

/// A ring of `count` rods in the plane of x and y, pinned at one; two ball joints between neighbours make a
/// hinge about z, although the ring already constrains the other directions. Joints of infinite stiffness are
/// rigid.
pub fn ring(count: usize, stiffness: f64) -> Scene {
    let mut scene = Scene::new(5.0, 1.0 / 120.0);
    let radius = ROD[0] / (PI / count as f64).tan();
    let place = |k: usize| {
        let turn = TAU * k as f64 / count as f64;
        plane(radius * turn.cos(), radius * turn.sin(), turn + FRAC_PI_2)
    };
    let bodies: Vec<Body> =
        (0..count).map(|k| scene.rigid(place(k), 1.0, box_inertia(1.0, ROD), ROD)).collect();
    for k in 0..count {
        for z in [-0.03, 0.03] {
            let ends = [bodies[k], bodies[(k + 1) % count]];
            scene.joint(ends, [Vec3::new(0.25, 0.0, z), Vec3::new(-0.25, 0.0, z)], stiffness, 700.0);
        }
    }
    let pin = scene.pin(place(0).position);
    scene.joint([pin, bodies[0]], [Vec3::zeros(); 2], stiffness, 700.0);
    scene
}
