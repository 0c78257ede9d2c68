//! Chains of rods through time: stability, order, speed and storage of the integrators.

#![cfg(feature = "macros")]

use forcec_runtime::prelude::*;
use forcec_runtime::{Body, Error, Integrator, Motion, World};

/// Ball joint.
#[constraint]
fn ball(a: Rigid, b: Rigid, arm_a: Vec3, arm_b: Vec3) -> Vec3 {
    (b.position - a.position) + (b.orientation * arm_b - a.orientation * arm_a)
}

const INTEGRATORS: [Integrator; 7] = [
    Integrator::LinearlyImplicitEuler,
    Integrator::PaperEuler,
    Integrator::Sdirk2,
    Integrator::GeneralizedAlpha,
    Integrator::Rodas4,
    Integrator::SymplecticEuler,
    Integrator::RungeKutta4,
];

const INERTIA: [f64; 3] = [(0.01 + 0.0036) / 12.0, (0.25 + 0.0036) / 12.0, (0.25 + 0.01) / 12.0];

/// Rods of 0.5 × 0.1 × 0.06 m and 1 kg end to end along x, turning at (3, 0, 0.5) about the first one's end.
fn chain(rods: usize, stiffness: f64, damping: f64) -> (World, Vec<Body>) {
    let mut world = World::default();
    world.gravity = Vec3::new(0.0, 0.0, -9.81);
    let spin = Vec3::new(3.0, 0.0, 0.5);
    let mut bodies = vec![world.add_rigid(Rigid::default(), Motion::Kinematic).unwrap()];
    for k in 0..rods {
        let position = Vec3::new(0.25 + 0.5 * k as f64, 0.0, 0.0);
        let state =
            Rigid { position, velocity: spin.cross(&position), angular_velocity: spin, ..Rigid::default() };
        bodies.push(world.add_rigid(state, Motion::Dynamic(1.0, Vec3::from(INERTIA))).unwrap());
        let moving = if k == 0 { 1.0 } else { 2.0 };
        let mobility = moving * (1.0 + 0.0625 / INERTIA[2]);
        let arm_a = if k == 0 { [0.0; 3] } else { [0.25, 0.0, 0.0] };
        let damping = damping * 2.0 * (stiffness / mobility).sqrt();
        let params = ball::Params { arm_a, arm_b: [-0.25, 0.0, 0.0], stiffness, damping };
        world.add(params, [bodies[k], bodies[k + 1]]).unwrap();
    }
    (world, bodies)
}

fn positions(world: &World, bodies: &[Body]) -> Vec<Vec3> {
    bodies.iter().map(|&body| world.rigid(body).unwrap().position).collect()
}

/// Kinetic and elastic energy, and with it the potential in gravity, zero at the pin.
fn energies(world: &World, bodies: &[Body]) -> (f64, f64) {
    let states: Vec<Rigid> = bodies.iter().map(|&body| world.rigid(body).unwrap()).collect();
    let potential: f64 = states.iter().map(|state| 9.81 * state.position.z).sum();
    let total = world.energy();
    (total - potential, total)
}

/// Positions after a time; `None` if a step was discarded or energy grew by more than one percent of the
/// larger of the initial energy and the range of kinetic and elastic energy.
fn run(stiffness: f64, h: f64, time: f64, integrator: Integrator) -> Option<Vec<Vec3>> {
    let (mut world, bodies) = chain(10, stiffness, 1.0);
    world.settings.integrator = integrator;
    // The test looks for growth of energy.
    world.settings.energy_growth = 1e6;
    world.settings.tolerance = 1e6;
    let (moving, start) = energies(&world, &bodies);
    let (mut low, mut high, mut most) = (moving, moving, start);
    for _ in 0..(time / h).round() as usize {
        let report = world.step(h).ok()?;
        if report.rejected > 0 {
            return None;
        }
        let (moving, total) = energies(&world, &bodies);
        (low, high, most) = (low.min(moving), high.max(moving), most.max(total));
    }
    let grown = (most - start) / start.abs().max(high - low);
    if grown > 0.01 {
        println!("{integrator:?}, ks {stiffness:e}, h {h:.2e}, {time} s: energy grows by {grown:.3}");
        return None;
    }
    Some(positions(&world, &bodies))
}

fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum();
    (sum / (a.len() - 1) as f64).sqrt()
}

/// The largest step that passes for a given time, such that all smaller steps of a geometric sequence pass
/// too.
fn largest(stiffness: f64, time: f64, integrator: Integrator) -> f64 {
    let mut h = 1e-3;
    while run(stiffness, 1.05 * h, time, integrator).is_some() && h < 0.1 {
        h *= 1.05;
    }
    h
}

#[test]
fn exact_terms_make_larger_steps_stable() {
    let [exact, paper] = [Integrator::LinearlyImplicitEuler, Integrator::PaperEuler]
        .map(|integrator| [1e6, 1e8].map(|stiffness| largest(stiffness, 5.0, integrator)));
    println!("largest steps, ks 1e6 and 1e8: exact {exact:?}, paper {paper:?}");
    assert!(exact[0] >= 1.2e-2 && exact[1] >= 4.5e-3);
    assert!(exact[0] >= 3.0 * paper[0] && exact[1] >= 3.0 * paper[1]);
}

#[test]
fn the_default_integrator_is_stable_and_accurate() {
    assert!(run(1e6, 1.0 / 60.0, 5.0, Integrator::Sdirk2).is_some());
    assert!(run(1e8, 1.0 / 120.0, 0.5, Integrator::Sdirk2).is_some());
    let fine = run(1e6, 1e-5, 0.5, Integrator::Sdirk2).unwrap();
    let error = distance(&run(1e6, 1.0 / 120.0, 0.5, Integrator::Sdirk2).unwrap(), &fine);
    println!("error at 1/120 {error:.3e} m");
    assert!(error <= 2e-4);
}

/// Rotation of bodies within a step does not stretch joints: stages converge at any joint stiffness.
#[test]
fn long_steps_of_stiff_joints_are_good() {
    let truth = {
        let (mut world, bodies) = chain(10, 1e7, 1.0);
        world.settings.integrator = Integrator::Rodas4;
        world.settings.tolerance = 1e-8;
        (0..30).for_each(|_| _ = world.step(1.0 / 60.0).unwrap());
        positions(&world, &bodies)
    };
    let (mut world, bodies) = chain(10, 1e7, 1.0);
    for step in 0..30 {
        assert_eq!(world.step(1.0 / 60.0).unwrap().rejected, 0, "step {step}");
    }
    let error = distance(&positions(&world, &bodies), &truth);
    assert!(error < 4e-3, "{error}");
}

#[test]
fn orders_of_convergence() {
    let soft = 1e3;
    let fine = run(soft, 5e-5, 0.2, Integrator::RungeKutta4).unwrap();
    let cases = [
        (Integrator::LinearlyImplicitEuler, 1.0, 1e-3),
        (Integrator::PaperEuler, 1.0, 1e-3),
        (Integrator::SymplecticEuler, 1.0, 1e-3),
        (Integrator::Sdirk2, 2.0, 1e-3),
        (Integrator::GeneralizedAlpha, 2.0, 1e-3),
        (Integrator::RungeKutta4, 4.0, 4e-3),
        (Integrator::Rodas4, 4.0, 4e-3),
    ];
    for (integrator, order, h) in cases {
        let [a, b] = [h, h / 2.0].map(|h| distance(&run(soft, h, 0.2, integrator).unwrap(), &fine));
        let measured = (a / b).log2();
        println!("{integrator:?}: errors {a:.3e} {b:.3e}, order {measured:.2}");
        assert!((measured - order).abs() < 0.3, "{integrator:?} is of order {measured}");
    }
}

/// A stiff joint damps the velocities of a method that balances forces only at stages.
#[test]
fn generalised_alpha_keeps_energy() {
    let [alpha, sdirk] = [Integrator::GeneralizedAlpha, Integrator::Sdirk2].map(|integrator| {
        let (mut world, bodies) = chain(10, 1e8, 1.0);
        world.settings.integrator = integrator;
        let (_, start) = energies(&world, &bodies);
        for _ in 0..240 {
            world.step(1.0 / 240.0).unwrap();
        }
        (energies(&world, &bodies).1 - start).abs()
    });
    println!("changes of energy: {alpha:.3e} J, {sdirk:.3e} J");
    assert!(alpha < 0.2 * sdirk);
}

/// An oscillation far faster than the steps decays by a factor of 0.6 per step, apart from a factor that is a
/// power of the number of steps.
#[test]
fn generalised_alpha_damps_the_fastest() {
    #[energy]
    fn well(p: Particle, stiffness: Real) -> Real {
        0.5 * stiffness * p.position.norm_squared()
    }
    let mut world = World::default();
    world.settings.integrator = Integrator::GeneralizedAlpha;
    world.settings.energy_growth = 1e6;
    let state = Particle { position: Vec3::x(), ..Particle::default() };
    let particle = world.add_particle(state, Motion::Dynamic(1.0, Vec3::zeros())).unwrap();
    world.add(well::Params { stiffness: 1e12 }, [particle]).unwrap();
    let sizes = [0; 60].map(|_| {
        world.step(1e-2).unwrap();
        world.particle(particle).unwrap().position.norm()
    });
    let shares = [20, 40].map(|k| sizes[k..k + 20].iter().fold(0.0_f64, |most, x| most.max(*x)));
    println!("of {:.1e} m: {:.1e}, {:.1e}", sizes[1], shares[0], shares[1]);
    assert!(sizes[1] > 0.0 && shares[1] < 20.0 * 0.6_f64.powi(20) * shares[0]);
}

#[test]
fn residuals_are_small() {
    for rods in [10, 1_000] {
        let (mut world, _) = chain(rods, 1e6, 1.0);
        world.settings.integrator = Integrator::LinearlyImplicitEuler;
        for _ in 0..3 {
            let report = world.step(1e-3).unwrap();
            assert!(report.residual <= 1e-10, "{report:?}");
        }
    }
}

#[test]
fn steps_allocate_nothing() {
    for integrator in INTEGRATORS {
        let (mut world, _) = chain(10, 1e6, 1.0);
        world.settings.integrator = integrator;
        world.step(1e-3).unwrap();
        let counted = allocation_counter::measure(|| {
            for _ in 0..10 {
                world.step(1e-3).unwrap();
            }
        });
        assert_eq!(counted.count_total, 0);
    }
}

#[test]
fn loops_are_solved() {
    let (mut world, bodies) = chain(100, 1e6, 1.0);
    let hub = bodies[50];
    for &body in &bodies[60..] {
        let arm = world.rigid(body).unwrap().position - world.rigid(hub).unwrap().position;
        let params = ball::Params { arm_a: arm.into(), arm_b: [0.0; 3], stiffness: 1e4, damping: 10.0 };
        world.add(params, [hub, body]).unwrap();
    }
    for _ in 0..10 {
        assert!(world.step(1e-3).unwrap().residual <= 1e-8);
    }
}

#[test]
fn wrong_things_are_refused() {
    let (mut world, bodies) = chain(3, 1e6, 1.0);
    let before = positions(&world, &bodies);
    assert_eq!(world.step(0.0).unwrap().accepted, 0);
    assert_eq!(positions(&world, &bodies), before);
    assert_eq!(world.step(-1.0), Err(Error::NegativeStep));
    assert_eq!(world.step(f64::NAN), Err(Error::NotFinite("step")));
    assert_eq!(world.add_rigid(Rigid::default(), Motion::Dynamic(0.0, Vec3::x())), Err(Error::NotPositive));
    let long = Quat::new_unchecked(nalgebra_quaternion(1.1));
    let body = world.add_rigid(Rigid { orientation: long, ..Rigid::default() }, Motion::Kinematic).unwrap();
    assert!((world.rigid(body).unwrap().orientation.norm() - 1.0).abs() < 1e-15);
    let none = Quat::new_unchecked(nalgebra_quaternion(0.0));
    let refused = world.add_rigid(Rigid { orientation: none, ..Rigid::default() }, Motion::Kinematic);
    assert_eq!(refused, Err(Error::NoOrientation));

    // A force that is not finite stops the step, and the state is the last good one.
    let params = ball::Params { arm_a: [f64::NAN; 3], arm_b: [0.0; 3], stiffness: 1.0, damping: 0.0 };
    assert_eq!(world.add(params, [bodies[1], bodies[2]]), Err(Error::NotFinite("ball")));
    let params = ball::Params { arm_a: [1e300; 3], stiffness: 1e300, ..params };
    let force = world.add(params, [bodies[1], bodies[2]]).unwrap();
    assert_eq!(world.step(1e-3).unwrap().quarantined, 1);
    assert_eq!(world.is_quarantined(bodies[1]), Ok(true));
    assert_eq!(positions(&world, &bodies), before);
    world.remove_force(force).unwrap();
    world.wake(bodies[1]).unwrap();
    assert_eq!(world.remove_force(force), Err(Error::UnknownHandle));
    assert!(world.step(1e-3).is_ok());

    // Handles outlive the removal of others.
    world.remove_body(bodies[1]).unwrap();
    assert_eq!(world.rigid(bodies[1]), Err(Error::UnknownHandle));
    assert!(world.rigid(bodies[2]).is_ok());
    assert_eq!(world.force_count(), 1);
    assert!(world.step(1e-3).is_ok());
}

fn nalgebra_quaternion(w: f64) -> forcec_runtime::nalgebra::Quaternion<f64> {
    forcec_runtime::nalgebra::Quaternion::new(w, 0.0, 0.0, 0.0)
}
