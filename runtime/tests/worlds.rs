//! Worlds of several islands: islands merge, split, sleep, wake, rest and are saved without an effect on
//! other islands.

#![cfg(feature = "macros")]

use forcec_runtime::prelude::*;
use forcec_runtime::{
    Body, Decoupling, Error, Force, Integrator, Motion, ParticleF32, Sleep, Solver, World, Wrench,
};

/// Ball joint.
#[constraint]
fn ball(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + (b.orientation * arm_b - a.orientation * arm_a)
}

/// Spring.
#[constraint]
fn spring(a: Particle, b: Particle, rest: Real) -> Real {
    (b.position - a.position).norm() - rest
}

/// A particle fixed to a body.
#[constraint(real = f64)]
fn hold(p: Particle, b: Rigid, arm: Vec3) -> Vec3 {
    (b.position - p.position) + b.orientation * arm
}

/// A force that brakes a body.
#[force(real = f64)]
fn brake(a: Rigid) -> Wrench {
    Wrench { force: -a.velocity, torque: -a.angular_velocity }
}

const JOINT: ball::Params =
    ball::Params { arm_a: [0.5, 0.0, 0.0], arm_b: [-0.5, 0.0, 0.0], stiffness: 1e5, damping: 100.0 };

/// A chain of rods hanging at a given height, and the joints of the chain.
fn chain(world: &mut World, rods: usize, height: f64) -> (Vec<Body>, Vec<Force>) {
    let motion = Motion::Dynamic(1.0, Vec3::new(0.02, 0.1, 0.1));
    let rod = |k: usize| Rigid {
        position: Vec3::new(k as f64, 0.0, height),
        angular_velocity: Vec3::new(0.3, 0.1 * k as f64, 0.2),
        ..Rigid::default()
    };
    let bodies: Vec<Body> = (0..rods).map(|k| world.add_rigid(rod(k), motion).unwrap()).collect();
    let joints = bodies.windows(2).map(|pair| world.add(JOINT, [pair[0], pair[1]]).unwrap()).collect();
    (bodies, joints)
}

fn states(world: &World, bodies: &[Body]) -> Vec<Rigid> {
    bodies.iter().map(|&body| world.rigid(body).unwrap()).collect()
}

fn run(world: &mut World, steps: usize) {
    for _ in 0..steps {
        world.step(5e-3).unwrap();
    }
}

#[test]
fn an_island_does_not_notice_the_others() {
    let mut alone = World::default();
    let (bodies, _) = chain(&mut alone, 5, 0.0);
    run(&mut alone, 40);
    let expected = states(&alone, &bodies);

    let mut world = World::default();
    chain(&mut world, 3, 10.0);
    let (bodies, _) = chain(&mut world, 5, 0.0);
    let (others, _) = chain(&mut world, 4, 20.0);
    // A force for which every step size fails.
    let params = ball::Params { arm_a: [1e300; 3], stiffness: 1e300, ..JOINT };
    world.add(params, [others[0], others[3]]).unwrap();
    let report = world.step(5e-3).unwrap();
    assert_eq!((report.awake, report.quarantined), (3, 1));
    run(&mut world, 39);
    assert_eq!(states(&world, &bodies), expected);
    assert_eq!(world.is_quarantined(others[2]), Ok(true));
    assert_eq!(world.is_quarantined(bodies[0]), Ok(false));
}

#[test]
fn islands_join_and_fall_apart() {
    let mut world = World::default();
    let (left, _) = chain(&mut world, 3, 0.0);
    let (right, joints) = chain(&mut world, 4, 0.0);
    assert_eq!(world.step(1e-3).unwrap().awake, 2);
    let link = world.add(JOINT, [left[2], right[0]]).unwrap();
    assert_eq!(world.step(1e-3).unwrap().awake, 1);
    world.remove_force(link).unwrap();
    assert_eq!(world.step(1e-3).unwrap().awake, 2);
    world.remove_force(joints[1]).unwrap();
    assert_eq!(world.step(1e-3).unwrap().awake, 3);
    world.remove_body(right[1]).unwrap();
    assert_eq!(world.rigid(right[1]), Err(Error::UnknownHandle));
    assert_eq!(world.remove_force(joints[0]), Err(Error::UnknownHandle));
    assert_eq!(world.step(1e-3).unwrap().awake, 3);
    // Handles of the remaining bodies still name the same bodies.
    assert!((world.rigid(right[3]).unwrap().position.x - 3.0).abs() < 0.1);
    assert_eq!(world.force_count(), 3);

    // A new body reuses the storage of a removed body under a different handle.
    let again = world.add_rigid(Rigid::default(), Motion::Dynamic(1.0, Vec3::repeat(1.0))).unwrap();
    assert_ne!(again, right[1]);
    assert_eq!(world.rigid(right[1]), Err(Error::UnknownHandle));
    assert!(world.rigid(again).is_ok());

    // A force needs at least one dynamic body.
    let fixed = [0, 1].map(|_| world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap());
    assert_eq!(world.add(JOINT, fixed), Err(Error::NothingMoves("ball")));
}

#[test]
fn a_world_changed_on_the_way_steps_as_one_made_so() {
    // Adding and then removing bodies leaves no trace.
    let mut world = World::default();
    let (bodies, _) = chain(&mut world, 5, 0.0);
    let mut changed = World::default();
    let (more, _) = chain(&mut changed, 7, 0.0);
    changed.remove_body(more[6]).unwrap();
    changed.remove_body(more[5]).unwrap();
    run(&mut world, 20);
    run(&mut changed, 20);
    let error = states(&world, &bodies)
        .iter()
        .zip(states(&changed, &more[..5]))
        .map(|(a, b)| (a.position - b.position).norm())
        .fold(0.0, f64::max);
    assert!(error < 1e-12, "{error:e}");
}

#[test]
fn sleeping_bodies_stay_at_rest_until_something_moves_them() {
    let mut world = World::default();
    let (bodies, joints) = chain(&mut world, 3, 0.0);
    let hand = world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap();
    let tether = ball::Params { arm_a: [0.0; 3], arm_b: [0.0; 3], stiffness: 10.0, damping: 1.0 };
    world.add(tether, [hand, bodies[0]]).unwrap();
    world.step(1e-3).unwrap();

    let asleep = |world: &mut World| {
        world.sleep(bodies[1]).unwrap();
        let before = states(world, &bodies);
        let report = world.step(1e-3).unwrap();
        assert_eq!((report.awake, world.is_asleep(bodies[2])), (0, Ok(true)));
        assert_eq!(states(world, &bodies), before);
    };
    let awake = |world: &mut World| {
        assert_eq!(world.step(1e-3).unwrap().awake, 1);
        assert_eq!(world.is_asleep(bodies[2]), Ok(false));
    };
    asleep(&mut world);
    world.wake(bodies[2]).unwrap();
    awake(&mut world);
    asleep(&mut world);
    world.set_rigid(bodies[0], Rigid::default()).unwrap();
    awake(&mut world);
    asleep(&mut world);
    world.set_load(bodies[0], Wrench { force: Vec3::x(), torque: Vec3::zeros() }).unwrap();
    awake(&mut world);
    asleep(&mut world);
    world.set_params(joints[0], ball::Params { stiffness: 1e4, ..JOINT }).unwrap();
    awake(&mut world);
    asleep(&mut world);
    world.set_rigid(hand, Rigid { velocity: Vec3::x(), ..Rigid::default() }).unwrap();
    awake(&mut world);
    // The body keeps moving, so the island does not go back to sleep.
    world.sleep(bodies[1]).unwrap();
    awake(&mut world);
}

#[test]
fn what_is_slow_falls_asleep() {
    let mut world = World::default();
    world.settings.sleep = Some(Sleep { speed: 1e-2, time: 0.1 });
    let (bodies, _) = chain(&mut world, 3, 0.0);
    for &body in &bodies {
        world.add_kernel::<brake::Output>((), &[body]).unwrap();
    }
    let mut steps = 0;
    while !world.is_asleep(bodies[0]).unwrap() {
        world.step(1e-2).unwrap();
        steps += 1;
        assert!(steps < 2_000);
    }
    assert!(states(&world, &bodies).iter().all(|state| state.velocity.norm() < 1e-2));
    assert_eq!(world.step(1e-2).unwrap().asleep, 1);
}

#[test]
fn solvers_agree() {
    let solve = |solver: Solver| {
        let mut world = World::default();
        world.settings.solver = solver;
        world.settings.integrator = Integrator::LinearlyImplicitEuler;
        // Particles at rest about their rest lengths: the system is symmetric.
        let grid: Vec<Body> = (0..25)
            .map(|k| {
                let position = Vec3::new((k % 5) as f64, (k / 5) as f64, 0.1 * (k % 3) as f64);
                let state = Particle { position, ..Particle::default() };
                world.add_particle(state, Motion::Dynamic(1.0 + 0.1 * k as f64, Vec3::zeros())).unwrap()
            })
            .collect();
        for k in 0..25 {
            for other in
                [k + 1, k + 5].into_iter().filter(|&other| other < 25 && (other % 5 != 0 || other == k + 5))
            {
                let params = spring::Params { rest: 0.9, stiffness: 1e3, damping: 5.0 };
                world.add(params, [grid[k], grid[other]]).unwrap();
            }
        }
        let report = world.step(1e-2).unwrap();
        assert!(report.residual < 1e-8, "{solver:?}: {report:?}");
        assert_eq!(report.iterations > 0, solver != Solver::Direct && solver != Solver::Automatic);
        assert_eq!((report.breakdowns, report.rejected), (0, 0), "{solver:?}");
        grid.iter().map(|&body| world.particle(body).unwrap().position).collect::<Vec<_>>()
    };
    let direct = solve(Solver::Direct);
    for solver in [Solver::Automatic, Solver::ConjugateGradients, Solver::BiCgStab, Solver::Cgs, Solver::BiCg]
    {
        let error = direct.iter().zip(solve(solver)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(error < 1e-9, "{solver:?}: {error:e}");
    }
}

#[test]
fn a_solver_that_breaks_down_says_so() {
    // The system matrix of a compressed spring in a soft world is not suitable for conjugate gradients.
    let step = |solver: Solver| {
        let mut world = World::default();
        world.settings.solver = solver;
        world.settings.integrator = Integrator::LinearlyImplicitEuler;
        let ends = [0.0, 1.0].map(|x| {
            let state = Particle { position: Vec3::new(x, 0.0, 0.0), ..Particle::default() };
            world.add_particle(state, Motion::Dynamic(1.0, Vec3::zeros())).unwrap()
        });
        let mass = ends[0];
        let params = spring::Params { rest: 2.0, stiffness: 1e6, damping: 0.0 };
        world.add(params, ends).unwrap();
        world.set_load(mass, Wrench { force: Vec3::new(0.0, 1.0, 0.0), torque: Vec3::zeros() }).unwrap();
        world.step(0.1).unwrap()
    };
    assert!(step(Solver::ConjugateGradients).breakdowns > 0);
    assert_eq!(step(Solver::Direct).breakdowns, 0);
}

#[test]
fn cuts_are_a_matter_of_the_seed() {
    let step = |decoupling: Option<Decoupling>| {
        let mut world = World::default();
        world.settings.decoupling = decoupling;
        let (bodies, _) = chain(&mut world, 30, 0.0);
        run(&mut world, 20);
        states(&world, &bodies)
    };
    let one = step(Some(Decoupling { limit: 5, seed: 1 }));
    assert_eq!(one, step(Some(Decoupling { limit: 5, seed: 1 })));
    assert_ne!(one, step(Some(Decoupling { limit: 5, seed: 2 })));
    assert_eq!(step(None), step(Some(Decoupling { limit: 30, seed: 1 })));
    let error = |a: &[Rigid], b: &[Rigid]| {
        a.iter().zip(b).map(|(a, b)| (a.position - b.position).norm()).fold(0.0, f64::max)
    };
    assert!(error(&one, &step(None)) < 0.1);
}

#[test]
fn blocks_of_three_and_of_six_agree() {
    let fall = |with_body: bool| {
        let mut world = World::default();
        world.gravity = Vec3::new(0.0, 0.0, -9.81);
        let pin = world.add_particle(Particle::default(), Motion::Kinematic).unwrap();
        let position = Vec3::new(1.0, 0.0, 0.0);
        let end = world
            .add_particle(Particle { position, ..Particle::default() }, Motion::Dynamic(1.0, Vec3::zeros()))
            .unwrap();
        world.add(spring::Params { rest: 1.0, stiffness: 1e4, damping: 10.0 }, [pin, end]).unwrap();
        if with_body {
            // A mass too small to affect the other bodies.
            let motion = Motion::Dynamic(1e-12, Vec3::repeat(1e-12));
            let body = world.add_rigid(Rigid { position, ..Rigid::default() }, motion).unwrap();
            let params = hold::Params { arm: [0.0; 3], stiffness: 1e-9, damping: 0.0 };
            world.add(params, [end, body]).unwrap();
        }
        run(&mut world, 50);
        world.particle(end).unwrap().position
    };
    assert!((fall(false) - fall(true)).norm() < 1e-7);
}

#[test]
fn single_precision_serves_far_away() {
    let fall = |origin: Vec3| {
        let mut world = World::<f32>::default();
        world.gravity = [0.0, 0.0, -9.81].into();
        let state = |x: f32| ParticleF32 { position: [x, 0.0, 0.0].into(), ..ParticleF32::default() };
        let pin = world.add_particle_at(origin, state(0.0), Motion::Kinematic).unwrap();
        let moved = Motion::Dynamic(1.0, [0.0; 3].into());
        let end = world.add_particle_at(origin, state(1.0), moved).unwrap();
        world.add(spring_f32::Params { rest: 1.0, stiffness: 1e4, damping: 10.0 }, [pin, end]).unwrap();
        for _ in 0..100 {
            world.step(5e-3).unwrap();
        }
        world.position(end).unwrap() - origin
    };
    let far = Vec3::new(1e6, -3e5, 2e6);
    assert!((fall(Vec3::zeros()) - fall(far)).norm() < 1e-9);
}

#[test]
fn a_step_can_be_looked_into() {
    let mut world = World::default();
    world.settings.integrator = Integrator::Rodas4;
    world.settings.tolerance = 1e-2;
    let spin = Vec3::new(1.0, 2.0, 3.0);
    let state = Rigid { angular_velocity: spin, velocity: Vec3::x(), ..Rigid::default() };
    let motion = Motion::Dynamic(1.0, Vec3::new(1.0, 2.0, 3.0));
    let body = world.add_rigid(state, motion).unwrap();
    assert_eq!(world.interpolate(body, 0.5), Ok(None));
    let mut fine = World::default();
    fine.settings.integrator = Integrator::RungeKutta4;
    let same = fine.add_rigid(state, motion).unwrap();
    assert_eq!(world.step(0.02).unwrap().accepted, 1);
    for tenth in 1..=10 {
        for _ in 0..10 {
            fine.step(2e-4).unwrap();
        }
        let seen = world.interpolate(body, f64::from(tenth) / 10.0).unwrap().unwrap();
        let exact = fine.rigid(same).unwrap();
        let error = (seen.position - exact.position).norm()
            + seen.orientation.angle_to(&exact.orientation)
            + (seen.angular_velocity - exact.angular_velocity).norm();
        assert!(error < 5e-6, "{tenth}: {error:e}");
    }
}

#[test]
fn energy_is_that_of_bodies_springs_and_gravity() {
    let mut world = World::default();
    world.gravity = Vec3::new(0.0, 0.0, -10.0);
    let at = |x: f64, z: f64| Particle { position: Vec3::new(x, 0.0, z), velocity: Vec3::new(0.0, 2.0, 0.0) };
    let a = world.add_particle(at(0.0, 1.0), Motion::Dynamic(3.0, Vec3::zeros())).unwrap();
    let b = world.add_particle(at(2.0, 1.0), Motion::Dynamic(1.0, Vec3::zeros())).unwrap();
    world.add(spring::Params { rest: 1.5, stiffness: 8.0, damping: 1.0 }, [a, b]).unwrap();
    // ½ 4 kg (2 m/s)² + 4 kg · 10 m/s² · 1 m + ½ 8 N/m (0.5 m)²
    assert!((world.energy() - (8.0 + 40.0 + 1.0)).abs() < 1e-12);
    let report = world.step(1e-6).unwrap();
    assert!((report.energy - 49.0).abs() < 1e-3 && (report.max_violation - 0.5).abs() < 1e-3);
}

/// In tests for energy loss, the energy removed by a force does not count as a loss.
#[test]
fn a_brake_may_take_energy() {
    for load in [0.0, -2.0] {
        let mut world = World::default();
        world.settings.energy_loss = Some(1e-9);
        let state = Rigid { velocity: Vec3::x() * 3.0, angular_velocity: Vec3::y(), ..Rigid::default() };
        let body = world.add_rigid(state, Motion::Dynamic(1.0, Vec3::repeat(0.1))).unwrap();
        world.add_kernel::<brake::Output>((), &[body]).unwrap();
        world.set_load(body, Wrench { force: Vec3::x() * load, torque: Vec3::zeros() }).unwrap();
        for _ in 0..20 {
            let report = world.step(5e-3).unwrap();
            assert_eq!((report.rejected, report.semi_definite), (0, 0));
        }
    }
}

#[cfg(feature = "serde")]
#[test]
fn a_saved_world_goes_on_bit_for_bit() {
    use forcec_runtime::{Kernels, Saved};
    let kernels = Kernels::new().with::<ball::Output>().with::<brake::Output>();
    let mut text = String::new();
    // The state that the second step reuses from the first step is saved too.
    for integrator in [Integrator::Sdirk2, Integrator::GeneralizedAlpha] {
        let mut world = World::default();
        world.gravity = Vec3::new(0.0, 0.0, -9.81);
        world.settings.integrator = integrator;
        let (bodies, joints) = chain(&mut world, 5, 0.0);
        chain(&mut world, 3, 5.0);
        let pin = world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap();
        world.add(ball::Params { arm_a: [0.0; 3], ..JOINT }, [pin, bodies[0]]).unwrap();
        world.add_kernel::<brake::Output>((), &[bodies[4]]).unwrap();
        world.remove_force(joints[3]).unwrap();
        run(&mut world, 10);

        text = serde_json::to_string(&world.save()).unwrap();
        let mut loaded = World::load(serde_json::from_str(&text).unwrap(), &kernels).unwrap();
        run(&mut world, 30);
        run(&mut loaded, 30);
        assert_eq!(states(&loaded, &bodies), states(&world, &bodies));
        assert_eq!(loaded.remove_force(joints[3]), Err(Error::UnknownHandle));
        loaded.remove_force(joints[0]).unwrap();
    }

    let saved = || serde_json::from_str::<Saved<f64>>(&text).unwrap();
    assert_eq!(World::load(saved(), &Kernels::new()).err(), Some(Error::UnknownKernel));
    let damaged = text.replacen("\"bodies\":[0,1]", "\"bodies\":[0,100]", 1);
    assert_ne!(damaged, text);
    let damaged = serde_json::from_str::<Saved<f64>>(&damaged).unwrap();
    assert_eq!(World::load(damaged, &kernels).err(), Some(Error::UnknownKernel));
}
