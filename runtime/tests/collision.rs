//! Contact: bodies that rest, slide, roll, fall and sleep.

#![cfg(feature = "collision")]

use forcec_runtime::collision::contact::point_contact;
use forcec_runtime::collision::parry::math::{Pose, Rotation, Vector};
use forcec_runtime::collision::parry::shape::{HeightFieldFlags, SharedShape};
use forcec_runtime::collision::parry::utils::Array2;
use forcec_runtime::collision::{Collisions, Contacts, Surface, motion};
use forcec_runtime::prelude::*;
use forcec_runtime::{Body, Error, Motion, Sleep, World};

const GRAVITY: f64 = 9.81;
const STEP: f64 = 1.0 / 240.0;

/// A world, its contacts and its step.
struct Scene {
    world: World,
    collisions: Collisions,
    h: f64,
}

impl Scene {
    fn empty(h: f64) -> Scene {
        let mut world = World::default();
        world.gravity = Vec3::z() * -GRAVITY;
        Scene { world, collisions: Collisions::default(), h }
    }

    /// A half-space whose surface is inclined by an angle about y, falling towards x.
    fn slope(angle: f64, friction: f64, h: f64) -> Scene {
        let mut scene = Scene::empty(h);
        let ground = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap();
        let solid = SharedShape::halfspace(Vector::new(angle.sin(), 0.0, angle.cos()));
        scene.collisions.add(ground, solid, Surface { friction, ..Surface::default() });
        scene
    }

    fn flat() -> Scene {
        Scene::slope(0.0, 0.5, STEP)
    }

    fn add(&mut self, shape: SharedShape, density: f64, friction: f64, state: Rigid) -> Body {
        let body = self.world.add_rigid(state, motion(&shape, density)).unwrap();
        self.collisions.add(body, shape, Surface { friction, ..Surface::default() });
        body
    }

    fn step(&mut self) -> Contacts {
        let contacts = self.collisions.update(&mut self.world, self.h).unwrap();
        let report = self.world.step(self.h).unwrap();
        assert_eq!(report.quarantined, 0);
        contacts
    }

    fn run(&mut self, time: f64) {
        for _ in 0..(time / self.h).round() as usize {
            self.step();
        }
    }

    fn state(&self, body: Body) -> Rigid {
        self.world.rigid(body).unwrap()
    }
}

fn at(position: Vec3) -> Rigid {
    Rigid { position, ..Rigid::default() }
}

fn cube(half: f64) -> SharedShape {
    SharedShape::cuboid(half, half, half)
}

/// Penetration of a stack of cubes, the top one 100 times heavier, in a time.
fn stack(count: usize, time: f64) -> f64 {
    let mut scene = Scene::flat();
    let boxes: Vec<Body> = (0..count)
        .map(|k| {
            let density = if k + 1 == count { 1e5 } else { 1e3 };
            scene.add(cube(0.5), density, 0.5, at(Vec3::z() * (0.5 + k as f64)))
        })
        .collect();
    let mut depth = 0.0_f64;
    for _ in 0..(time / scene.h).round() as usize {
        depth = depth.max(scene.step().depth);
    }
    let top = scene.state(boxes[count - 1]);
    assert!(top.velocity.norm() < 1e-6, "{:e}", top.velocity.norm());
    assert!((top.position - Vec3::z() * (count as f64 - 0.5)).norm() < 0.02 * count as f64);
    depth
}

#[test]
fn a_box_rests_on_a_plane() {
    let depth = stack(1, 60.0);
    assert!(depth < 1e-4, "{depth}");
}

#[test]
fn a_stack_of_ten_bears_a_heavy_one() {
    let depth = stack(10, 60.0);
    println!("penetration {depth:.5} m");
    assert!(depth <= 0.01, "{depth}");
}

#[test]
fn a_ball_rolls_down_a_slope() {
    let angle = 0.3_f64;
    let mut scene = Scene::slope(angle, 0.8, STEP);
    let up = Vec3::new(angle.sin(), 0.0, angle.cos());
    let ball = scene.add(SharedShape::ball(0.5), 1e3, 0.8, at(up * 0.5));
    scene.run(2.0);
    let state = scene.state(ball);
    let speed = 5.0 / 7.0 * GRAVITY * angle.sin() * 2.0;
    assert!((state.velocity.norm() / speed - 1.0).abs() < 1e-3, "{} for {speed}", state.velocity.norm());
    assert!((state.angular_velocity.y * 0.5 / speed - 1.0).abs() < 1e-3);
    assert!((state.position.dot(&up) - 0.5).abs() < 1e-3);
}

#[test]
fn a_capsule_rolls_as_fast_as_its_inertia_lets_it() {
    let angle = 0.3_f64;
    let mut scene = Scene::slope(angle, 0.8, STEP);
    let up = Vec3::new(angle.sin(), 0.0, angle.cos());
    let shape = SharedShape::capsule_y(0.5, 0.2);
    let Motion::Dynamic(mass, moments) = motion(&shape, 1e3) else { panic!("no mass") };
    let capsule = scene.add(shape, 1e3, 0.8, at(up * 0.2));
    scene.run(2.0);
    let speed = GRAVITY * angle.sin() * 2.0 / (1.0 + moments.y / (mass * 0.04));
    let rolled = scene.state(capsule).velocity.norm();
    assert!((rolled / speed - 1.0).abs() < 1e-3, "{rolled} for {speed}");
}

#[test]
fn a_box_slides_as_far_as_friction_lets_it() {
    let mut scene = Scene::slope(0.0, 0.4, STEP);
    let state = Rigid { velocity: Vec3::x() * 4.0, ..at(Vec3::z() * 0.1) };
    let body = scene.add(SharedShape::cuboid(0.5, 0.5, 0.1), 1e3, 0.4, state);
    scene.run(3.0);
    let (way, state) = (16.0 / (2.0 * 0.4 * GRAVITY), scene.state(body));
    assert!((state.position.x / way - 1.0).abs() < 1e-3, "{} for {way}", state.position.x);
    assert!(state.velocity.norm() < 1e-3);
}

#[test]
fn a_box_on_a_slope_slides_only_beyond_the_angle_of_friction() {
    let slid = |friction: f64| {
        let angle = 0.3_f64;
        let mut scene = Scene::slope(angle, friction, STEP);
        let up = Vec3::new(angle.sin(), 0.0, angle.cos());
        let orientation = Quat::from_scaled_axis(Vec3::y() * angle);
        let state = Rigid { orientation, ..at(up * 0.1) };
        let body = scene.add(SharedShape::cuboid(0.5, 0.5, 0.1), 1e3, friction, state);
        scene.run(1.0);
        (scene.state(body).position - up * 0.1).norm()
    };
    let way = 0.5 * GRAVITY * (0.3_f64.sin() - 0.2 * 0.3_f64.cos());
    assert!((slid(0.2) / way - 1.0).abs() < 1e-2, "{} for {way}", slid(0.2));
    // tan 0.3 = 0.309: it creeps at the slip speed.
    assert!(slid(0.4) < 4e-3, "{}", slid(0.4));
}

#[test]
fn a_hull_falls_onto_a_face() {
    let mut scene = Scene::flat();
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let hull = SharedShape::convex_hull(&corners.map(|corner| Vector::from(corner) * 0.3)).unwrap();
    let orientation = Quat::from_scaled_axis(Vec3::new(0.3, 0.2, 0.0));
    let body = scene.add(hull, 1e3, 0.5, Rigid { orientation, ..at(Vec3::z()) });
    scene.run(4.0);
    // The centre of a regular tetrahedron lies a third of its circumradius above a face.
    let height = 0.3 * 3.0_f64.sqrt() / 3.0;
    assert!((scene.state(body).position.z - height).abs() < 1e-3, "{}", scene.state(body).position.z);
    assert!(scene.state(body).velocity.norm() < 1e-3);
}

/// Boxes above a bumpy height field.
fn rubble(count: usize) -> (Scene, Vec<Body>) {
    let mut scene = Scene::empty(1.0 / 120.0);
    let ground = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap();
    let heights = (0..9 * 9).map(|k| 0.3 * f64::from(k * 29 % 11) / 11.0).collect();
    let field = SharedShape::heightfield_with_flags(
        Array2::new(9, 9, heights),
        Vector::new(8.0, 1.0, 8.0),
        HeightFieldFlags::FIX_INTERNAL_EDGES,
    );
    // The heights of the field are along y.
    let upright = Pose::from_parts(Vector::ZERO, Rotation::from_rotation_x(std::f64::consts::FRAC_PI_2));
    scene.collisions.add_at(ground, upright, field, Surface { friction: 0.8, ..Surface::default() });
    let bodies = (0..count).map(|k| {
        let position = Vec3::new((k % 3) as f64 - 1.0, (k / 3 % 3) as f64 - 1.0, 1.0 + (k / 9) as f64);
        let turn = Vec3::new(0.3, 0.1 * k as f64, -0.2);
        let state = Rigid { orientation: Quat::from_scaled_axis(turn), ..at(position) };
        scene.add(SharedShape::cuboid(0.3, 0.2 + 0.01 * (k % 5) as f64, 0.25), 500.0, 0.8, state)
    });
    let bodies = bodies.collect();
    (scene, bodies)
}

#[test]
fn boxes_on_a_height_field_gain_no_energy_and_fall_asleep() {
    let (mut scene, bodies) = rubble(18);
    scene.world.settings.sleep = Some(Sleep { speed: 0.05, time: 0.5 });
    let mut least = scene.world.energy();
    let start = least;
    for k in 0..120 * 20 {
        scene.step();
        let energy = scene.world.energy();
        assert!(energy <= least + 1e-3 * start, "{k}: {energy} after {least}");
        least = least.min(energy);
    }
    for &body in &bodies {
        assert!(scene.world.is_asleep(body).unwrap());
        assert!(scene.state(body).position.z > 0.15);
    }
    let contacts = scene.step();
    assert_eq!((contacts.pairs, contacts.changes), (0, 0));
}

#[test]
fn what_moves_wakes_what_it_touches() {
    let mut scene = Scene::flat();
    scene.world.settings.sleep = Some(Sleep { speed: 0.05, time: 0.5 });
    let near = scene.add(cube(0.5), 1e3, 0.5, at(Vec3::z() * 0.5));
    let pile = scene.add(cube(0.5), 1e3, 0.5, at(Vec3::z() * 1.5));
    let far = scene.add(cube(0.5), 1e3, 0.5, at(Vec3::new(9.0, 0.0, 0.5)));
    scene.run(1.0);
    let sleepers = |scene: &Scene| [near, pile, far].map(|body| scene.world.is_asleep(body).unwrap());
    assert_eq!(sleepers(&scene), [true; 3]);
    let before = scene.state(pile);

    let ball = scene.add(
        SharedShape::ball(0.2),
        1e3,
        0.5,
        Rigid { velocity: Vec3::x() * 4.0, ..at(Vec3::new(-2.0, 0.0, 1.5)) },
    );
    scene.run(0.25);
    assert_eq!(sleepers(&scene), [true; 3]);
    scene.run(0.25);
    assert_eq!(sleepers(&scene), [false, false, true]);
    assert!(scene.state(pile).position.x > before.position.x);

    // Removing a body removes its contacts, and bodies on top fall.
    scene.world.remove_body(ball).unwrap();
    scene.run(3.0);
    assert_eq!(sleepers(&scene), [true; 3]);
    scene.world.remove_body(near).unwrap();
    scene.run(3.0);
    assert!((scene.state(pile).position.z - 0.5).abs() < 1e-2, "{}", scene.state(pile).position.z);
    assert_eq!(scene.world.force_count(), 8);
}

#[test]
fn a_box_at_rest_that_is_thrown_leaves_the_ground() {
    let mut scene = Scene::flat();
    let body = scene.add(cube(0.5), 1e3, 0.5, at(Vec3::z() * 0.5));
    scene.run(1.0);
    let rest = scene.state(body);
    scene.world.set_rigid(body, Rigid { velocity: Vec3::z() * 1.0, ..rest }).unwrap();
    let mut height = 0.0_f64;
    for _ in 0..60 {
        scene.step();
        height = height.max(scene.state(body).position.z - rest.position.z);
    }
    let free = 1.0 / (2.0 * GRAVITY);
    assert!((height / free - 1.0).abs() < 1e-2, "{height} for {free}");
}

#[test]
fn a_moving_platform_takes_a_box_along() {
    let mut scene = Scene::empty(STEP);
    let state = Rigid { velocity: Vec3::x() * 0.5, ..Rigid::default() };
    let platform = scene.world.add_rigid(state, Motion::Kinematic).unwrap();
    scene.collisions.add(platform, SharedShape::cuboid(2.0, 2.0, 0.5), Surface::default());
    let body = scene.add(cube(0.25), 1e3, 0.5, at(Vec3::z() * 0.75));
    scene.run(2.0);
    assert!((scene.state(body).velocity.x - 0.5).abs() < 1e-6);
    assert!((scene.state(body).position.z - 0.75).abs() < 1e-3);
}

#[test]
fn bodies_that_are_excluded_pass_through_each_other() {
    let fallen = |excluded: bool| {
        let mut scene = Scene::flat();
        let low = scene.add(cube(0.5), 1e3, 0.5, at(Vec3::z() * 0.5));
        let high = scene.add(cube(0.25), 1e3, 0.5, at(Vec3::z() * 1.5));
        if excluded {
            scene.collisions.exclude(high, low);
        }
        scene.run(2.0);
        scene.state(high).position.z
    };
    assert!((fallen(false) - 1.25).abs() < 1e-3);
    assert!((fallen(true) - 0.25).abs() < 1e-3);
}

#[test]
fn a_surface_may_say_how_stiff_it_is() {
    let mut scene = Scene::flat();
    let body = scene.world.add_rigid(at(Vec3::z() * 0.5), motion(&cube(0.5), 1e3)).unwrap();
    let surface = Surface { stiffness: Some(1e5), damping: Some(1e4), ..Surface::default() };
    let collider = scene.collisions.add(body, cube(0.5), surface);
    scene.run(2.0);
    // Four corners bear 1000 kg.
    let sunk = 0.5 - scene.state(body).position.z;
    assert!((sunk - 1e3 * GRAVITY / 4e5).abs() < 1e-6, "{sunk}");
    scene.collisions.remove(&mut scene.world, collider).unwrap();
    assert_eq!(scene.collisions.remove(&mut scene.world, collider), Err(Error::UnknownHandle));
    assert_eq!(scene.world.force_count(), 0);
}

#[test]
fn shapes_without_a_known_contact_are_an_error() {
    let mut scene = Scene::flat();
    let body = scene.world.add_rigid(at(Vec3::z() * 0.1), Motion::Dynamic(1.0, Vec3::repeat(1.0))).unwrap();
    scene.collisions.add(body, SharedShape::halfspace(Vector::Z), Surface::default());
    assert_eq!(scene.collisions.update(&mut scene.world, STEP), Err(Error::NoContact));
    assert_eq!(scene.collisions.update(&mut scene.world, -STEP), Err(Error::NegativeStep));
    assert_eq!(scene.collisions.update(&mut scene.world, f64::NAN), Err(Error::NotFinite("step")));
}

#[test]
fn the_same_fall_gives_the_same_bits() {
    let fall = || {
        let (mut scene, bodies) = rubble(18);
        scene.run(2.0);
        bodies.iter().map(|&body| scene.state(body)).collect::<Vec<_>>()
    };
    assert_eq!(fall(), fall());
}

#[test]
fn wrenches_of_a_contact_balance() {
    let a = Rigid {
        orientation: Quat::from_scaled_axis(Vec3::new(0.4, -0.2, 0.7)),
        angular_velocity: Vec3::new(1.0, -2.0, 0.5),
        ..at(Vec3::new(0.1, -0.3, 0.2))
    };
    let b = Rigid { velocity: Vec3::new(0.3, 0.2, -1.0), ..at(Vec3::new(0.2, 0.1, 1.0)) };
    let normal = Vec3::new(0.1, 0.3, 0.9).normalize();
    let (arm_a, arm_b) = (Vec3::new(0.2, 0.1, 0.4), Vec3::new(0.1, 0.0, -0.5));
    let (on_a, on_b) = point_contact(a, b, arm_a, arm_b, normal, 0.1, 0.2, 1e4, 1e2, 0.5, 1e-2);
    assert!(on_b.force.norm() > 1.0);
    assert!((on_a.force + on_b.force).norm() < 1e-12);
    let momentum = |body: Rigid, wrench: Wrench| body.position.cross(&wrench.force) + wrench.torque;
    assert!((momentum(a, on_a) + momentum(b, on_b)).norm() < 1e-12 * on_b.force.norm().max(1.0) * 10.0);
}
