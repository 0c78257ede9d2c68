//! Rigid constraints: multipliers in place of stiffness, by explicit and implicit methods, alone and in lanes.

#![cfg(feature = "macros")]

use forcec_runtime::prelude::*;
use forcec_runtime::{Body, Error, Integrator, Law, Motion, World, Worlds, Wrench};

const GRAVITY: f64 = 9.81;

/// Ball joint.
#[constraint(real = f64)]
fn ball(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + (b.orientation * arm_b - a.orientation * arm_a)
}

/// Hinge about the axis y of both bodies.
#[constraint(real = f64)]
fn hinge(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> (Vec3, Real, Real) {
    let axis = b.orientation * Vec3::y();
    let gap = (b.position - a.position) + (b.orientation * arm_b - a.orientation * arm_a);
    (gap, axis.dot(&(a.orientation * Vec3::x())), axis.dot(&(a.orientation * Vec3::z())))
}

/// A rod between particles.
#[constraint(real = f64)]
fn rod(a: Particle, b: Particle, length: Real) -> Real {
    (b.position - a.position).norm() - length
}

/// A particle above ground.
#[constraint(real = f64, unilateral)]
fn floor(p: Particle) -> Real {
    p.position.z
}

/// A torsion spring of a hinge, as an energy.
#[energy(real = f64)]
fn twist(a: Rigid, b: Rigid, stiffness: Real) -> Real {
    let x = a.orientation * Vec3::x() - b.orientation * Vec3::x();
    0.5 * stiffness * x.norm_squared()
}

fn world(integrator: Integrator) -> World {
    let mut world = World::default();
    world.gravity = Vec3::new(0.0, 0.0, -GRAVITY);
    world.settings.integrator = integrator;
    world.settings.tolerance = f64::INFINITY;
    world
}

const ROD: Motion<f64> = Motion::Dynamic(1.0, Vec3::new(0.01, 0.09, 0.08));

/// Rods of 1 m end to end along x, pinned at a point, joined by rigid ball joints; each spins.
fn chain(world: &mut World, at: Vec3, rods: usize) -> Vec<Body> {
    let pin = world.add_rigid(Rigid { position: at, ..Rigid::default() }, Motion::Kinematic).unwrap();
    let mut above = (pin, [0.0; 3]);
    let mut bodies = Vec::new();
    for k in 0..rods {
        let position = at + Vec3::new(0.5 + k as f64, 0.0, 0.0);
        let velocity = Vec3::new(0.0, 2.0 * (0.5 + k as f64), 0.0);
        let state =
            Rigid { position, velocity, angular_velocity: Vec3::new(0.3, 0.0, 2.0), ..Rigid::default() };
        let body = world.add_rigid(state, ROD).unwrap();
        let params = ball::Params { arm_a: above.1, arm_b: [-0.5, 0.0, 0.0], stiffness: 1.0, damping: 0.0 };
        world.add_constraint(Law::Rigid, params, [above.0, body]).unwrap();
        above = (body, [0.5, 0.0, 0.0]);
        bodies.push(body);
    }
    bodies
}

fn states(world: &World, bodies: &[Body]) -> Vec<Rigid> {
    bodies.iter().map(|&body| world.rigid(body).unwrap()).collect()
}

fn distance(a: &[Rigid], b: &[Rigid]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a.position - b.position).norm()).fold(0.0, f64::max)
}

/// Where a chain of three rods is after half a second, and the largest gap and change of energy.
fn swing(integrator: Integrator, steps: usize) -> (Vec<Rigid>, f64, f64) {
    let mut world = world(integrator);
    let bodies = chain(&mut world, Vec3::zeros(), 3);
    let start = world.energy();
    let (mut gap, mut drift) = (0.0_f64, 0.0_f64);
    for _ in 0..steps {
        let report = world.step(0.5 / steps as f64).unwrap();
        gap = gap.max(report.max_violation);
        drift = drift.max((report.energy - start).abs());
    }
    (states(&world, &bodies), gap, drift)
}

#[test]
fn a_pendulum_is_where_elliptic_functions_say() {
    // IFToMM benchmark A01: a point mass on a massless rod, from (−1, 0).
    let mut world = world(Integrator::RungeKutta4);
    let pin = world.add_particle(Particle::default(), Motion::Kinematic).unwrap();
    let state = Particle { position: Vec3::new(-1.0, 0.0, 0.0), ..Particle::default() };
    let mass = world.add_particle(state, Motion::Dynamic(1.0, Vec3::zeros())).unwrap();
    let params = rod::Params { length: 1.0, stiffness: 1.0, damping: 0.0 };
    world.add_constraint(Law::Rigid, params, [pin, mass]).unwrap();
    let mut drift = 0.0_f64;
    for _ in 0..5000 {
        drift = drift.max(world.step(2e-3).unwrap().energy.abs());
    }
    let end = world.particle(mass).unwrap().position;
    let exact = Vec3::new(-0.275_087_462_576_116_9, 0.0, -0.961_419_205_099_125_1);
    assert!((end - exact).norm() < 1e-7, "{end} {:e}", (end - exact).norm());
    assert!(drift < 1e-7, "{drift:e}");
}

#[test]
fn methods_have_their_orders_on_rigid_chains() {
    let fine = swing(Integrator::RungeKutta4, 4000).0;
    for (integrator, steps, order, gap) in [
        (Integrator::RungeKutta4, 50, 4.0, 1e-8),
        (Integrator::Sdirk2, 200, 2.0, 1e-8),
        (Integrator::LinearlyImplicitEuler, 400, 1.0, 1e-8),
        (Integrator::SymplecticEuler, 400, 1.0, 1e-8),
    ] {
        let [coarse, half] = [steps, 2 * steps].map(|steps| swing(integrator, steps));
        let [e, f] = [&coarse, &half].map(|run| distance(&run.0, &fine));
        assert!((e / f).log2() > order - 0.3, "{integrator:?}: {e:e} {f:e}");
        assert!(coarse.1 < gap && half.1 < gap, "{integrator:?}: gaps {:e} {:e}", coarse.1, half.1);
    }
    let (_, gap, drift) = swing(Integrator::RungeKutta4, 200);
    assert!(gap < 1e-9 && drift < 1e-5, "{gap:e} {drift:e}");
}

#[test]
fn other_implicit_methods_take_steps_of_sdirk2() {
    let expected = swing(Integrator::Sdirk2, 50).0;
    for integrator in [Integrator::GeneralizedAlpha, Integrator::Rodas4] {
        assert_eq!(swing(integrator, 50).0, expected, "{integrator:?}");
    }
}

#[test]
fn a_chain_without_a_pin_keeps_its_momentum() {
    for integrator in [Integrator::RungeKutta4, Integrator::Sdirk2] {
        let mut world = world(integrator);
        world.gravity = Vec3::zeros();
        // Branches at the first rod, from which no joint leads to the world.
        let rods: Vec<Body> = (0..6)
            .map(|k| {
                let position = Vec3::new(k as f64, 0.0, 0.0);
                let angular_velocity = Vec3::new(0.0, 0.3 * k as f64, 1.0);
                world.add_rigid(Rigid { position, angular_velocity, ..Rigid::default() }, ROD).unwrap()
            })
            .collect();
        for (a, b) in [(0, 1), (1, 2), (0, 3), (3, 4), (0, 5)] {
            let arm = Vec3::new(0.5 * (b as f64 - a as f64), 0.0, 0.0);
            let params =
                ball::Params { arm_a: arm.into(), arm_b: (-arm).into(), stiffness: 0.0, damping: 0.0 };
            world.add_constraint(Law::Rigid, params, [rods[a], rods[b]]).unwrap();
        }
        let momentum = |world: &World| {
            states(world, &rods).iter().fold([Vec3::zeros(); 2], |[linear, angular], rod| {
                let turn = rod.orientation.to_rotation_matrix();
                let spin = turn.transpose() * rod.angular_velocity;
                let own = turn * spin.component_mul(&Vec3::new(0.01, 0.09, 0.08));
                [linear + rod.velocity, angular + own + rod.position.cross(&rod.velocity)]
            })
        };
        // The first step makes velocities meet.
        world.step(1e-3).unwrap();
        let start = momentum(&world);
        for _ in 0..500 {
            assert!(world.step(1e-3).unwrap().max_violation < 1e-9, "{integrator:?}");
        }
        let end = momentum(&world);
        let change = (end[0] - start[0]).norm() + (end[1] - start[1]).norm();
        assert!(change < 1e-4, "{integrator:?}: {change:e}");
    }
}

#[test]
fn lanes_do_not_change_bits() {
    let run = |lanes: usize| {
        let mut world = world(Integrator::RungeKutta4);
        world.settings.lanes = Some(lanes);
        world.settings.tolerance = 1e-4;
        let mut bodies = Vec::new();
        for k in 0..11 {
            let own = chain(&mut world, Vec3::new(0.0, 10.0 * k as f64, 0.0), 3);
            // Chains differ, and the wildest need shorter steps.
            let mut state = world.rigid(own[2]).unwrap();
            state.angular_velocity += Vec3::new(3.0, 1.0, 0.0) * k as f64;
            world.set_rigid(own[2], state).unwrap();
            bodies.extend(own);
        }
        let mut rejected = 0;
        for step in 0..60 {
            if step == 20 {
                let load = Wrench { force: Vec3::x(), torque: Vec3::y() };
                world.set_load(bodies[4], load).unwrap();
            }
            if step == 30 {
                // One chain leaves its group.
                world.remove_body(bodies[17]).unwrap();
                bodies.remove(17);
            }
            rejected += world.step(1.0 / 60.0).unwrap().rejected;
        }
        (states(&world, &bodies), world.energy().to_bits(), rejected)
    };
    let alone = run(1);
    assert!(alone.2 > 0 && alone.2 < 600, "{}", alone.2);
    for lanes in [2, 4, 8] {
        assert_eq!(run(lanes), alone, "{lanes} lanes");
    }
}

#[test]
fn rigid_rows_stand_beside_energies_penalties_and_loads() {
    for integrator in [Integrator::RungeKutta4, Integrator::Sdirk2] {
        let mut world = world(integrator);
        let bodies = chain(&mut world, Vec3::zeros(), 2);
        world.add(twist::Params { stiffness: 20.0 }, [bodies[0], bodies[1]]).unwrap();
        let side = world
            .add_rigid(Rigid { position: Vec3::new(1.5, 0.0, 1.0), ..Rigid::default() }, Motion::Kinematic);
        let params = ball::Params { arm_a: [0.0; 3], arm_b: [0.0; 3], stiffness: 50.0, damping: 2.0 };
        world.add(params, [side.unwrap(), bodies[1]]).unwrap();
        let start = world.energy();
        for _ in 0..2400 {
            let report = world.step(1.0 / 240.0).unwrap();
            assert!(report.max_violation.is_finite() && report.quarantined == 0);
        }
        assert!(world.energy() < start);
        let speeds = states(&world, &bodies).iter().map(|body| body.velocity.norm()).fold(0.0, f64::max);
        assert!(speeds < 2.0, "{integrator:?}: {speeds}");
    }
}

#[test]
fn a_moving_pin_works_on_the_chain() {
    // A rod on a pin that moves at 1 m/s is the same seen from a pin at rest.
    let run = |speed: f64, integrator: Integrator| {
        let mut world = world(integrator);
        let drift = Vec3::new(speed, 0.0, 0.0);
        let pin = Rigid { velocity: drift, ..Rigid::default() };
        let pin = world.add_rigid(pin, Motion::Kinematic).unwrap();
        let state = Rigid { position: Vec3::new(0.5, 0.0, 0.0), velocity: drift, ..Rigid::default() };
        let body = world.add_rigid(state, ROD).unwrap();
        let params = ball::Params { arm_a: [0.0; 3], arm_b: [-0.5, 0.0, 0.0], stiffness: 1.0, damping: 0.0 };
        world.add_constraint(Law::Rigid, params, [pin, body]).unwrap();
        let mut rejected = 0;
        for _ in 0..200 {
            rejected += world.step(5e-3).unwrap().rejected;
        }
        assert_eq!(rejected, 0, "{integrator:?}");
        world.rigid(body).unwrap().position - drift * 1.0
    };
    for integrator in [Integrator::RungeKutta4, Integrator::Sdirk2] {
        let difference = (run(1.0, integrator) - run(0.0, integrator)).norm();
        assert!(difference < 1e-9, "{integrator:?}: {difference:e}");
    }
}

/// A square of four rods whose hinges repeat each other's rows, on a fixed side.
fn four_bar(world: &mut World) -> [Body; 3] {
    let bar = |x: f64, z: f64, up: bool| {
        let turn = if up { -std::f64::consts::FRAC_PI_2 } else { 0.0 };
        let orientation = forcec_runtime::nalgebra::UnitQuaternion::from_axis_angle(&Vec3::y_axis(), turn);
        let velocity = Vec3::new(if up { 0.5 } else { 1.0 }, 0.0, 0.0);
        let angular_velocity = if up { Vec3::y() } else { Vec3::zeros() };
        Rigid { position: Vec3::new(x, 0.0, z), orientation, velocity, angular_velocity }
    };
    let ground = world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap();
    let [left, top, right] = [bar(0.0, 0.5, true), bar(0.5, 1.0, false), bar(1.0, 0.5, true)]
        .map(|state| world.add_rigid(state, ROD).unwrap());
    let (begin, end) = ([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]);
    for (bodies, arm_a, arm_b) in [
        ([ground, left], [0.0; 3], begin),
        ([left, top], end, begin),
        ([right, top], end, end),
        ([ground, right], [1.0, 0.0, 0.0], begin),
    ] {
        let params = hinge::Params { arm_a, arm_b, stiffness: 1.0, damping: 0.0 };
        world.add_constraint(Law::Rigid, params, bodies).unwrap();
    }
    [left, top, right]
}

#[test]
fn repeated_rows_of_loops_have_a_solution() {
    for (integrator, steps, most) in [(Integrator::RungeKutta4, 1000, 1e-5), (Integrator::Sdirk2, 1000, 0.2)]
    {
        let mut world = world(integrator);
        let [left, top, right] = four_bar(&mut world);
        let start = world.energy();
        let (mut gap, mut drift) = (0.0_f64, 0.0_f64);
        for _ in 0..steps {
            let report = world.step(2e-3).unwrap();
            assert_eq!(report.quarantined + report.rejected, 0);
            gap = gap.max(report.max_violation);
            drift = drift.max((report.energy - start).abs());
        }
        assert!(gap < 1e-8 && drift < most, "{integrator:?}: gap {gap:e}, energy {drift:e}");
        // It stays a parallelogram.
        let [left, top, right] = [left, top, right].map(|body| world.rigid(body).unwrap());
        assert!((right.position - left.position - Vec3::x()).norm() < 1e-7);
        assert!((left.position - top.position).y.abs() < 1e-7);
    }
}

#[test]
fn loads_are_sampled_in_stages() {
    let end = |steps: usize, sampled: bool| {
        let mut world = world(Integrator::RungeKutta4);
        let bodies = chain(&mut world, Vec3::zeros(), 2);
        let h = 0.5 / steps as f64;
        let load = |time: f64| Wrench { force: Vec3::zeros(), torque: Vec3::y() * (9.0 * time).sin() };
        for k in 0..steps {
            let start = k as f64 * h;
            if sampled {
                let last = bodies[1];
                let at = |time: f64, body: Body, state: &Rigid| {
                    assert!(state.position.iter().all(|x| x.is_finite()));
                    if body == last { load(start + time) } else { Wrench::default() }
                };
                world.step_with(h, at).unwrap();
            } else {
                world.set_load(bodies[1], load(start + 0.5 * h)).unwrap();
                world.step(h).unwrap();
            }
        }
        states(&world, &bodies)
    };
    let fine = end(2000, true);
    let [e, f] = [25, 50].map(|steps| distance(&end(steps, true), &fine));
    assert!((e / f).log2() > 3.7, "{e:e} {f:e}");
    let held = distance(&end(50, false), &fine);
    assert!(held > 5.0 * f, "{held:e} {f:e}");
}

#[test]
fn the_gap_controls_steps() {
    let error = |tolerance: f64| {
        let mut world = world(Integrator::RungeKutta4);
        world.settings.tolerance = tolerance;
        let bodies = chain(&mut world, Vec3::zeros(), 3);
        let mut accepted = 0;
        for _ in 0..10 {
            accepted += world.step(0.05).unwrap().accepted;
        }
        (distance(&states(&world, &bodies), &swing(Integrator::RungeKutta4, 4000).0), accepted)
    };
    let [loose, tight] = [1e-3, 1e-7].map(error);
    assert!(tight.0 < 5e-2 * loose.0 && tight.1 > loose.1, "{loose:?} {tight:?}");
}

#[test]
fn laws_are_checked() {
    let mut world = world(Integrator::Sdirk2);
    let [a, b] = [0.0, 1.0].map(|x| {
        let state = Particle { position: Vec3::new(x, 0.0, 0.0), ..Particle::default() };
        world.add_particle(state, Motion::Dynamic(1.0, Vec3::zeros())).unwrap()
    });
    let params = floor::Params { stiffness: 1.0, damping: 0.0 };
    assert_eq!(world.add_constraint(Law::Rigid, params, [a]).unwrap_err(), Error::OneSided("floor"));
    let params = rod::Params { length: 1.0, stiffness: 1.0, damping: 0.0 };
    assert_eq!(world.add_constraint(Law::Compliance(-1.0), params, [a, b]).unwrap_err(), Error::NotPositive);
    // A compliance of 1e-4 m/N is a stiffness of 1e4 N/m.
    let state = Particle { position: Vec3::new(1.5, 0.0, 0.0), ..Particle::default() };
    let force = world.add_constraint(Law::Compliance(1e-4), params, [a, b]).unwrap();
    world.set_particle(b, state).unwrap();
    assert!((world.energy() - world.gravity.z.abs() * 0.0 - 0.5 * 1e4 * 0.25).abs() < 1e-9);
    world.remove_force(force).unwrap();
    world.add_constraint(Law::Compliance(0.0), params, [a, b]).unwrap();
    assert_eq!(world.energy(), 0.0);
}

#[test]
fn copies_of_a_world_are_worlds() {
    let make = || {
        let mut world = world(Integrator::RungeKutta4);
        let bodies = chain(&mut world, Vec3::zeros(), 3);
        (world, bodies)
    };
    let load = |k: usize| Wrench { force: Vec3::new(k as f64, 0.0, 0.0), torque: Vec3::zeros() };
    let (mut template, bodies) = make();
    let mut worlds = Worlds::new(&mut template, 13);
    worlds.set_loads(bodies[2], &(0..13).map(load).collect::<Vec<_>>()).unwrap();
    for _ in 0..30 {
        worlds.step(1.0 / 120.0).unwrap();
    }
    for k in 0..13 {
        let (mut world, bodies) = make();
        world.set_load(bodies[2], load(k)).unwrap();
        for _ in 0..30 {
            world.step(1.0 / 120.0).unwrap();
        }
        for &body in &bodies {
            assert_eq!(worlds.rigid(body).unwrap().nth(k), world.rigid(body).ok());
        }
    }
    assert_eq!(worlds.set_loads(bodies[0], &[]).unwrap_err(), Error::WrongCount);
}

#[test]
fn steps_allocate_nothing() {
    for integrator in [Integrator::RungeKutta4, Integrator::SymplecticEuler, Integrator::Sdirk2] {
        let mut world = world(integrator);
        world.settings.lanes = Some(4);
        // One bundle, or one island by implicit methods: several may go to several threads.
        for k in 0..if integrator == Integrator::Sdirk2 { 1 } else { 4 } {
            chain(&mut world, Vec3::new(0.0, 10.0 * k as f64, 0.0), 3);
        }
        for _ in 0..3 {
            world.step(1e-3).unwrap();
        }
        let counted = allocation_counter::measure(|| {
            for _ in 0..5 {
                world.step(1e-3).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0, "{integrator:?}");
    }
}
