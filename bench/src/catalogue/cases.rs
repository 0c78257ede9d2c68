//! The cases, one function each where a line does not do.

use super::{Case, Seen, Verdict, hash, stable, watch};
use crate::scenes::{Chain, ROD, Scene, box_inertia, c10, t_handle};
use forcec_constraints::joints::{
    distance, point_to_point, point_to_point_f32, point_to_point_norm, torsion_spring,
};
use forcec_runtime::collision::parry::math::Vector;
use forcec_runtime::collision::parry::shape::SharedShape;
use forcec_runtime::collision::{Collisions, Surface};
use forcec_runtime::nalgebra::{Quaternion, Vector3};
use forcec_runtime::prelude::{Particle, Quat, Rigid, Vec3, constraint};
use forcec_runtime::{Body, Decoupling, Error, Motion, Report, RigidF32, World, Wrench};

/// All of them, in order.
pub const CASES: [Case; 35] = [
    Case { number: 1, title: "ks 10^0 … 10^12 × h 10^−5 … 10^−1: **U** at every h", run: sweep },
    Case {
        number: 2,
        title: "no damping, h = 1/60: **U**",
        run: |quick| stable(&|| Chain { damping: 0.0, ..Chain::default() }.scene(), time(quick), 1.0 / 60.0),
    },
    Case {
        number: 3,
        title: "100 × critical damping, h = 1e-3: **U**",
        run: |quick| stable(&|| Chain { damping: 100.0, ..Chain::default() }.scene(), time(quick), 1e-3),
    },
    Case {
        number: 4,
        title: "end mass 1e3, ks 1e7, h = 1/60: **U**",
        run: |quick| {
            let chain =
                Chain { stiffness: 1e7, mass: |k, n| if k + 1 == n { 1e3 } else { 1.0 }, ..Chain::default() };
            stable(&|| chain.scene(), time(quick), 1.0 / 60.0)
        },
    },
    Case { number: 5, title: "end mass 1e6, ks 1e10, h = 1/240: **U**", run: heavy },
    Case {
        number: 6,
        title: "end mass 1e-6, h = 1/120: **U**",
        run: |quick| {
            let chain = Chain { mass: |k, n| if k + 1 == n { 1e-6 } else { 1.0 }, ..Chain::default() };
            stable(&|| chain.scene(), time(quick), 1.0 / 120.0)
        },
    },
    Case {
        number: 7,
        title: "masses alternate 1 and 1e4, h = 1/240: **U**",
        run: |quick| {
            let chain = Chain { mass: |k, _| if k % 2 == 0 { 1.0 } else { 1e4 }, ..Chain::default() };
            stable(&|| chain.scene(), time(quick), 1.0 / 240.0)
        },
    },
    Case {
        number: 8,
        title: "needles, inertia 1 : 1 : 1e-4, h = 1/120: **U**",
        run: |quick| {
            let moment = box_inertia(1.0, ROD).z;
            let chain = Chain { inertia: [1e-4 * moment, moment, moment], ..Chain::default() };
            stable(&|| chain.scene(), time(quick), 1.0 / 120.0)
        },
    },
    Case {
        number: 9,
        title: "chain of 1e4 links, h = 1e-3: **U**, solve ≤ 6 ms, linear in n within 30 %",
        run: long,
    },
    Case { number: 10, title: "1e4 bodies on one hub: no fill-in, solve ≤ 6 ms", run: hub },
    Case { number: 11, title: "ring of 100 bodies, redundant joints: **U**, residual ≤ 1e-8", run: ring },
    Case { number: 12, title: "20 × 20 net of joints, corners pinned, 1e4 steps: **U**", run: net },
    Case {
        number: 13,
        title: "chain stretched 1 m a joint: gap < 1 cm within 1 s, speed < 100 m/s",
        run: |_| {
            let mut scene = Chain { stretch: 1.0, ..Chain::default() }.scene();
            let seen = watch(&mut scene, 1.0, |_| 1.0 / 120.0);
            Verdict {
                passes: seen.is_stable() && seen.last_gap < 0.01 && seen.last_speed < 100.0,
                text: format!(
                    "{seen}; after 1 s gap {:.1e} m, speed {:.1} m/s; speed on the way {:.0} m/s",
                    seen.last_gap, seen.last_speed, seen.speed
                ),
            }
        },
    },
    Case {
        number: 14,
        title: "T-handle, 20 s, frames of 1/60, RODAS4: energy 1e-3, momentum 1e-4, 7 ± 1 flips",
        run: flips,
    },
    Case {
        number: 15,
        title: "asymmetric body at 1e3 rad/s, frames of 1/60, RODAS4: momentum 1e-3",
        run: |_| {
            let (seen, momentum, _) = tumble(Vec3::new(600.0, 600.0, 529.0), 1.0);
            Verdict {
                passes: seen.finite && seen.quarantined == 0 && momentum <= 1e-3,
                text: format!(
                    "momentum {momentum:.1e}, {:.0} steps a frame",
                    seen.accepted as f64 / seen.steps as f64
                ),
            }
        },
    },
    Case {
        number: 16,
        title: "double pendulum, no damping, 100 s, h = 1e-3: energy within 1e-3",
        run: pendulum,
    },
    Case {
        number: 17, title: "C = x₁ − x₀ at zero length: finite force and derivatives", run: tie_at_zero
    },
    Case {
        number: 18,
        title: "norm form at distances 1e-300 … 1e-8: **U**, or quarantined and reported",
        run: short,
    },
    Case { number: 19, title: "coincident bodies and anchors: **U**", run: coincident },
    Case { number: 20, title: "angle at 0, 1e-12, π − 1e-12, π: derivative within 1e-6", run: angles },
    Case {
        number: 21,
        title: "quaternion of norm 0, 1e-160: error; of norm 1.1: normalised",
        run: quaternions,
    },
    Case {
        number: 22,
        title: "NaN or infinity in state, parameter, force, h: error or quarantine; other islands bit-identical",
        run: not_finite,
    },
    Case { number: 23, title: "finite garbage, 1e300: error or quarantine", run: garbage },
    Case {
        number: 24,
        title: "1e6 m from the origin, f64: gap changes ≤ 1 %",
        run: |quick| {
            let gap = |origin| {
                watch(&mut Chain { origin, ..Chain::default() }.scene(), time(quick), |_| 1.0 / 120.0).gap
            };
            let (near, far) = (gap([0.0; 3]), gap([1e6, -1e6, 1e6]));
            let change = (far / near - 1.0).abs();
            Verdict { passes: change <= 0.01, text: format!("gap {near:.4e} → {far:.4e} m") }
        },
    },
    Case {
        number: 25,
        title: "f32 at 1e3 m, and at 1e5 m with ks 1e8: gap ≤ 1.1 × that at the origin",
        run: single_far,
    },
    Case {
        number: 26,
        title: "f32 against f64, h = 1e-3: gap within 3 %",
        run: |quick| {
            let single = single_gap([0.0; 3], 1e6, 1e-3, time(quick));
            let double = watch(&mut c10(1e6), time(quick), |_| 1e-3).gap;
            let change = (single / double - 1.0).abs();
            Verdict {
                passes: change <= 0.03,
                text: format!("gap {double:.4e} m in f64, {single:.4e} m in f32"),
            }
        },
    },
    Case {
        number: 27,
        title: "h = 0: identity; h < 0: error",
        run: |_| {
            let mut scene = c10(1e6);
            let before = hash(&scene);
            let zero = scene.world.step(0.0).is_ok() && hash(&scene) == before;
            let negative = scene.world.step(-1e-3) == Err(Error::NegativeStep) && hash(&scene) == before;
            Verdict { passes: zero && negative, text: format!("identity {zero}, error {negative}") }
        },
    },
    Case {
        number: 28,
        title: "h alternates 1/60 and 1e-5: **U**",
        run: |quick| {
            let seen = watch(&mut c10(1e6), time(quick), |k| if k % 2 == 0 { 1.0 / 60.0 } else { 1e-5 });
            Verdict { passes: seen.is_stable(), text: seen.to_string() }
        },
    },
    Case {
        number: 29,
        title: "inertia with a zero entry: rejected",
        run: |_| {
            let refused = World::<f64>::default()
                .add_rigid(Rigid::default(), Motion::Dynamic(1.0, Vec3::new(1.0, 0.0, 1.0)));
            Verdict { passes: refused == Err(Error::NotPositive), text: format!("{refused:?}") }
        },
    },
    Case { number: 30, title: "torque of 1e6 N·m for one step: recovers in ≤ 10 halvings", run: kick },
    Case {
        number: 31,
        title: "500 bodies cut at 50, seeds 1 … 20: gap ≤ 3 × uncut; same seed, same bits",
        run: cuts,
    },
    Case { number: 32, title: "1, 2, 8 threads: the same bits", run: threads },
    Case {
        number: 33,
        title: "1e4 sleep and wake cycles: energy within 1e-6 J; asleep < 2 % of awake",
        run: sleepers,
    },
    Case {
        number: 34,
        title: "box on a plane, stack of 10 with the top 100 × heavier, penalty contact: ≤ 1 cm for 60 s",
        run: boxes,
    },
    Case {
        number: 35,
        title: "a derivative's sign flipped: the check fails and names the entry",
        run: flipped,
    },
];

/// How long the base scene runs, s.
fn time(quick: bool) -> f64 {
    if quick { 1.0 } else { 5.0 }
}

fn sweep(quick: bool) -> Verdict {
    let sizes: &[i32] = if quick { &[-2, -1] } else { &[-5, -4, -3, -2, -1] };
    let (mut bad, mut rejected, mut backups, mut worst) = (Vec::new(), 0, 0, 0.0_f64);
    for power in (0..=12).step_by(2) {
        for &size in sizes {
            let h = 10.0_f64.powi(size);
            let seen = watch(&mut c10(10.0_f64.powi(power)), time(quick), |_| h);
            (rejected, backups) = (rejected + seen.rejected, backups + seen.backups);
            worst = worst.max(seen.growth);
            if !seen.is_stable() {
                bad.push(format!("ks 1e{power} h 1e{size}: {seen}"));
            }
        }
    }
    let text = format!(
        "energy at most +{worst:.1e}, {rejected} steps discarded, {backups} back-ups; not **U**: {}",
        if bad.is_empty() { "none".to_owned() } else { bad.join("; ") }
    );
    Verdict { passes: bad.is_empty(), text }
}

fn heavy(quick: bool) -> Verdict {
    let chain =
        Chain { stiffness: 1e10, mass: |k, n| if k + 1 == n { 1e6 } else { 1.0 }, ..Chain::default() };
    let mut verdict = stable(&|| chain.scene(), time(quick), 1.0 / 240.0);
    let sizes = [0.1, 1.0 / 15.0, 1.0 / 30.0, 1.0 / 60.0, 1.0 / 120.0];
    let unaided = |h: &&f64| {
        let seen = watch(&mut chain.scene(), time(quick), |_| **h);
        seen.is_stable() && seen.rejected == 0
    };
    let largest = sizes.iter().find(unaided);
    let largest = largest.map_or("none of 1/120 and above".to_owned(), |h| format!("{h:.4} s"));
    verdict.text += &format!("; largest step without a discarded one: {largest}");
    verdict
}

fn long(quick: bool) -> Verdict {
    let steps = if quick { 20 } else { 5000 };
    let run = |rods: usize, steps: usize| {
        watch(&mut Chain { rods, ..Chain::default() }.scene(), steps as f64 * 1e-3, |_| 1e-3)
    };
    // SDIRK2 solves twice a step.
    let solve =
        |seen: &Seen| seen.solve.as_secs_f64() * 1e3 / (2 * (seen.accepted + seen.rejected)).max(1) as f64;
    let long = run(10_000, steps);
    let mut ratios: Vec<f64> = (0..5)
        .map(|_| {
            let (many, few) = (run(10_000, 10), run(1_000, 100));
            solve(&many) / (10.0 * solve(&few))
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let (each, ratio) = (solve(&long), ratios[2]);
    Verdict {
        passes: long.is_stable() && each <= 6.0 && ratio <= 1.3,
        text: format!("{long}; {each:.2} ms a solve; a body of 1e4 takes {ratio:.2} × one of 1e3"),
    }
}

fn hub(_: bool) -> Verdict {
    let mut scene = Scene::new(0.1, 1e-3);
    let pin = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).expect("a pin");
    let hub = scene.rigid(Rigid::default(), 100.0, Vec3::repeat(10.0), [0.5; 3]);
    let joint = |arm_a: [f64; 3], stiffness| point_to_point::Params {
        arm_a,
        arm_b: [0.0; 3],
        stiffness,
        damping: 2.0 * 1e3,
    };
    scene.world.add(joint([0.0; 3], 1e8), [pin, hub]).expect("a joint");
    for k in 0..10_000 {
        let turn = 0.01 * k as f64;
        let arm = Vec3::new(turn.cos(), turn.sin(), 1e-4 * k as f64);
        let spoke =
            scene.rigid(Rigid { position: arm, ..Rigid::default() }, 1.0, Vec3::repeat(0.1), [0.1; 3]);
        scene.world.add(joint(arm.into(), 1e6), [hub, spoke]).expect("a joint");
    }
    let seen = watch(&mut scene, 0.05, |_| 1e-3);
    let each = seen.solve.as_secs_f64() * 1e3 / (2 * (seen.accepted + seen.rejected)).max(1) as f64;
    Verdict {
        passes: seen.finite && seen.quarantined == 0 && each <= 6.0 && seen.residual <= 1e-8,
        text: format!("{each:.2} ms a solve, residual {:.0e}, {seen}", seen.residual),
    }
}

fn ring(quick: bool) -> Verdict {
    let make = || {
        let mut scene = Scene::new(5.0, 1.0 / 120.0);
        let count = 100;
        let radius = 0.25 / (std::f64::consts::PI / count as f64).tan();
        let place = |k: usize| {
            let turn = std::f64::consts::TAU * k as f64 / count as f64;
            let orientation = Quat::from_axis_angle(&Vec3::z_axis(), turn + std::f64::consts::FRAC_PI_2);
            let position = Vec3::new(radius * turn.cos(), radius * turn.sin(), 0.0);
            Rigid { position, orientation, ..Rigid::default() }
        };
        let bodies: Vec<Body> =
            (0..count).map(|k| scene.rigid(place(k), 1.0, box_inertia(1.0, ROD), ROD)).collect();
        let pin = scene.world.add_rigid(place(0), Motion::Kinematic).expect("a pin");
        let mut joint = |a: Body, b: Body, arm_a: [f64; 3], arm_b: [f64; 3]| {
            let params = point_to_point::Params { arm_a, arm_b, stiffness: 1e6, damping: 700.0 };
            scene.world.add(params, [a, b]).expect("a joint");
        };
        for k in 0..count {
            // Two joints where one would do: a hinge about z, and the ring holds the rest anyway.
            for z in [-0.03, 0.03] {
                joint(bodies[k], bodies[(k + 1) % count], [0.25, 0.0, z], [-0.25, 0.0, z]);
            }
        }
        joint(pin, bodies[0], [0.0; 3], [0.0; 3]);
        scene
    };
    let verdict = stable(&make, time(quick), 1.0 / 120.0);
    let residual = watch(&mut make(), 0.5, |_| 1.0 / 120.0).residual;
    Verdict {
        passes: verdict.passes && residual <= 1e-8,
        text: format!("{}, residual {residual:.0e}", verdict.text),
    }
}

fn net(quick: bool) -> Verdict {
    let mut scene = Scene::new(5.0, 1.0 / 120.0);
    let side = 20;
    let grid: Vec<Body> = (0..side * side)
        .map(|k| {
            let position = Vec3::new((k % side) as f64 * 0.5, (k / side) as f64 * 0.5, 0.0);
            scene.rigid(Rigid { position, ..Rigid::default() }, 1.0, Vec3::repeat(0.02), [0.2, 0.2, 0.02])
        })
        .collect();
    let mut joint = |a: Body, b: Body, arm_a: [f64; 3], arm_b: [f64; 3]| {
        let params = point_to_point::Params { arm_a, arm_b, stiffness: 1e6, damping: 500.0 };
        scene.world.add(params, [a, b]).expect("a joint");
    };
    for k in 0..side * side {
        if k % side + 1 < side {
            joint(grid[k], grid[k + 1], [0.25, 0.0, 0.0], [-0.25, 0.0, 0.0]);
        }
        if k + side < side * side {
            joint(grid[k], grid[k + side], [0.0, 0.25, 0.0], [0.0, -0.25, 0.0]);
        }
    }
    for corner in [0, side - 1, side * (side - 1), side * side - 1] {
        let position = scene.world.position(grid[corner]).expect("a corner");
        let pin =
            scene.world.add_rigid(Rigid { position, ..Rigid::default() }, Motion::Kinematic).expect("a pin");
        let params =
            point_to_point::Params { arm_a: [0.0; 3], arm_b: [0.0; 3], stiffness: 1e6, damping: 500.0 };
        scene.world.add(params, [pin, grid[corner]]).expect("a joint");
    }
    let steps = if quick { 100.0 } else { 1e4 };
    let seen = watch(&mut scene, steps / 120.0, |_| 1.0 / 120.0);
    Verdict { passes: seen.is_stable(), text: format!("{seen}, {} steps", seen.steps) }
}

/// A free body with moments 1, 2, 3, stepped by `Rodas4` a frame at a time: what was seen, the change of its angular
/// momentum, and how often its middle axis turned over.
fn tumble(spin: Vec3, time: f64) -> (Seen, f64, usize) {
    let mut scene = t_handle();
    let body = scene.bodies[0];
    let state = Rigid { angular_velocity: spin, ..Rigid::default() };
    scene.world.set_rigid(body, state).expect("a state");
    let moments = Vec3::new(1.0, 2.0, 3.0);
    let momentum = |state: &Rigid| {
        let own = state.orientation.inverse() * state.angular_velocity;
        state.orientation * own.component_mul(&moments)
    };
    let start = momentum(&state);
    let (mut change, mut flips, mut up) = (0.0_f64, 0, true);
    let mut whole = Seen { finite: true, ..Seen::default() };
    let before = scene.world.energy();
    for _ in 0..(time * 60.0).round() as usize {
        let seen = watch(&mut scene, 1.0 / 60.0, |_| 1.0 / 60.0);
        whole.steps += 1;
        whole.accepted += seen.accepted;
        whole.rejected += seen.rejected;
        whole.quarantined += seen.quarantined;
        whole.finite &= seen.finite;
        whole.growth = whole.growth.max((scene.world.energy() / before - 1.0).abs());
        let state = scene.world.rigid(body).expect("the body");
        change = change.max((momentum(&state) - start).norm() / start.norm());
        let now = (state.orientation * Vec3::y()).y > 0.0;
        flips += usize::from(now != up);
        up = now;
    }
    (whole, change, flips)
}

fn flips(_: bool) -> Verdict {
    let (seen, momentum, flips) = tumble(Vec3::new(0.01, 10.0, 0.0), 20.0);
    let frames = seen.steps as f64;
    Verdict {
        passes: seen.growth <= 1e-3 && momentum <= 1e-4 && (6..=8).contains(&flips),
        text: format!(
            "energy {:.1e}, momentum {momentum:.1e}, {flips} flips, {:.1} steps a frame",
            seen.growth,
            seen.accepted as f64 / frames
        ),
    }
}

fn pendulum(quick: bool) -> Verdict {
    let mut scene = Chain { rods: 2, damping: 0.0, ..Chain::default() }.scene();
    scene.world.settings.energy_loss = Some(1e-7);
    let start = scene.world.energy();
    let (mut worst, mut least) = (0.0_f64, f64::MAX);
    let steps = if quick { 5_000 } else { 100_000 };
    let mut most = f64::MIN;
    let (mut accepted, mut rejected) = (0, 0);
    for k in 0..steps {
        let report = scene.advance(k as f64 * 1e-3, 1e-3);
        let moving = report.energy - scene.potential();
        (least, most) = (least.min(moving), most.max(moving));
        worst = worst.max((report.energy - start).abs());
        accepted += report.accepted;
        rejected += report.rejected;
    }
    let worst = worst / start.abs().max(most - least);
    let each = f64::from(accepted as u32 + rejected as u32) / f64::from(steps);
    Verdict {
        passes: worst <= 1e-3,
        text: format!("energy within {worst:.1e} with `energy_loss` 1e-7, {each:.1} steps in 1e-3 s"),
    }
}

/// Two particles at one place.
#[constraint(real = f64)]
fn tie(a: Particle, b: Particle) -> Vec3 {
    b.position - a.position
}

fn tie_at_zero(_: bool) -> Verdict {
    let (a, b) = (Particle::default(), Particle::default());
    let mut out = tie::Output::default();
    tie::evaluate(&a, &b, &tie::Params { stiffness: 1e6, damping: 1e3 }, &mut out);
    let numbers = out.force.iter().chain(out.dfdx.as_flattened()).chain(out.dfdv.as_flattened());
    let finite = numbers.into_iter().all(|x| x.is_finite());
    Verdict {
        passes: finite && out.dfdx[0][0] == -1e6,
        text: format!("finite {finite}, ∂F/∂x = {:e}", out.dfdx[0][0]),
    }
}

fn short(_: bool) -> Verdict {
    let (mut stood, mut stable, mut bad) = (Vec::new(), 0, Vec::new());
    for power in [-300, -200, -160, -150, -100, -50, -16, -12, -8] {
        let make = || {
            let mut scene = Scene::new(0.5, 1.0 / 120.0);
            let pin = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).expect("a pin");
            let position = Vec3::new(10.0_f64.powi(power), 0.0, 0.0);
            let body = scene.rigid(Rigid { position, ..Rigid::default() }, 1.0, Vec3::repeat(0.1), [0.1; 3]);
            let params = point_to_point_norm::Params {
                arm_a: [0.0; 3],
                arm_b: [0.0; 3],
                stiffness: 1e6,
                damping: 100.0,
            };
            scene.world.add(params, [pin, body]).expect("a joint");
            scene
        };
        let seen = watch(&mut make(), 0.5, |_| 1.0 / 120.0);
        match (seen.quarantined, seen.is_stable()) {
            (1.., _) => stood.push(format!("1e{power}")),
            (0, true) => stable += 1,
            (0, false) => bad.push(format!("1e{power}: {seen}")),
        }
    }
    Verdict {
        passes: bad.is_empty(),
        text: format!("{stable} **U**; quarantined: {}; neither: {}", list(&stood), list(&bad)),
    }
}

fn list(items: &[String]) -> String {
    if items.is_empty() { "none".to_owned() } else { items.join(", ") }
}

fn coincident(quick: bool) -> Verdict {
    let make = || {
        let mut scene = Scene::new(1.0, 1.0 / 120.0);
        let pin = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).expect("a pin");
        let mut last = pin;
        for _ in 0..5 {
            let body = scene.rigid(Rigid::default(), 1.0, Vec3::repeat(0.1), [0.1; 3]);
            let params =
                point_to_point::Params { arm_a: [0.0; 3], arm_b: [0.0; 3], stiffness: 1e6, damping: 500.0 };
            scene.world.add(params, [last, body]).expect("a joint");
            scene.world.add(params, [pin, body]).expect("a joint");
            last = body;
        }
        scene
    };
    let joints = stable(&make, time(quick), 1.0 / 120.0);
    // A rod of length 1 whose anchors lie on each other has no direction: that is for quarantine.
    let mut scene = Scene::new(1.0, 1.0 / 120.0);
    let pin = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).expect("a pin");
    let body = scene.rigid(Rigid::default(), 1.0, Vec3::repeat(0.1), [0.1; 3]);
    let params = distance::Params {
        arm_a: [0.0; 3],
        arm_b: [0.0; 3],
        rest_length: 1.0,
        stiffness: 1e6,
        damping: 100.0,
    };
    scene.world.add(params, [pin, body]).expect("a rod");
    let rod = watch(&mut scene, 0.1, |_| 1.0 / 120.0);
    Verdict {
        passes: joints.passes && rod.finite && (rod.quarantined > 0 || rod.is_stable()),
        text: format!(
            "joints: {}; a rod without direction: {}",
            joints.text,
            if rod.quarantined > 0 { "quarantined" } else { "moves" }
        ),
    }
}

fn angles(_: bool) -> Verdict {
    let (stiffness, pi) = (10.0, std::f64::consts::PI);
    let params = torsion_spring::Params {
        axis_a: [0.0, 0.0, 1.0],
        normal_a: [1.0, 0.0, 0.0],
        normal_b: [1.0, 0.0, 0.0],
        stiffness,
        damping: 0.0,
    };
    let mut worst = 0.0_f64;
    for angle in [0.0, 1e-12, pi - 1e-12, pi] {
        let b = Rigid { orientation: Quat::from_axis_angle(&Vec3::z_axis(), angle), ..Rigid::default() };
        let mut out = torsion_spring::Output::default();
        torsion_spring::evaluate(&Rigid::default(), &b, &params, &mut out);
        // Torque on b is −k θ, its derivative along θ is −k.
        worst = worst
            .max((out.dfdx[11][11] / -stiffness - 1.0).abs())
            .max((out.force[11].abs() - stiffness * angle).abs());
    }
    Verdict { passes: worst <= 1e-6, text: format!("error at most {worst:.1e}") }
}

fn quaternions(_: bool) -> Verdict {
    let mut world = World::<f64>::default();
    let mut add = |w: f64| {
        let orientation = Quat::new_unchecked(Quaternion::new(w, 0.0, 0.0, 0.0));
        world.add_rigid(Rigid { orientation, ..Rigid::default() }, Motion::Kinematic)
    };
    let refused = add(0.0) == Err(Error::NoOrientation) && add(1e-160) == Err(Error::NoOrientation);
    let body = add(1.1);
    let norm = body.and_then(|body| world.rigid(body)).map_or(f64::NAN, |state| state.orientation.norm());
    Verdict { passes: refused && (norm - 1.0).abs() < 1e-15, text: format!("refused {refused}, norm {norm}") }
}

/// Two chains apart from each other in one world.
fn two_chains() -> (Scene, usize) {
    let mut scene = c10(1e6);
    let count = scene.bodies.len();
    let pin = scene
        .world
        .add_rigid(Rigid { position: Vec3::new(0.0, 5.0, 0.0), ..Rigid::default() }, Motion::Kinematic)
        .expect("a pin");
    let mut last = (pin, 0.0);
    for k in 0..count {
        let position = Vec3::new(0.25 + 0.5 * k as f64, 5.0, 0.0);
        let body = scene.rigid(Rigid { position, ..Rigid::default() }, 1.0, box_inertia(1.0, ROD), ROD);
        let params = point_to_point::Params {
            arm_a: [last.1, 0.0, 0.0],
            arm_b: [-0.25, 0.0, 0.0],
            stiffness: 1e6,
            damping: 700.0,
        };
        scene.world.add(params, [last.0, body]).expect("a joint");
        last = (body, 0.25);
    }
    (scene, count)
}

fn not_finite(_: bool) -> Verdict {
    let mut good = two_chains().0;
    let (mut bad, count) = two_chains();
    let victim = bad.bodies[count];
    let mut state = bad.world.rigid(victim).expect("a body");
    state.velocity.x = f64::NAN;
    let states = bad.world.set_rigid(victim, state).is_err();
    state.velocity.x = f64::INFINITY;
    let states = states && bad.world.set_rigid(victim, state).is_err();
    let params = |arm: f64, stiffness: f64| point_to_point::Params {
        arm_a: [arm; 3],
        arm_b: [0.0; 3],
        stiffness,
        damping: 1.0,
    };
    let ends = [bad.bodies[count], bad.bodies[count + 1]];
    let parameters = bad.world.add(params(0.0, f64::NAN), ends).is_err()
        && bad.world.add(params(0.0, f64::INFINITY), ends).is_err();
    let steps = bad.world.step(f64::NAN).is_err() && bad.world.step(f64::INFINITY).is_err();
    // A force that overflows.
    bad.world.add(params(1e200, 1e200), ends).expect("finite parameters");
    let mut quarantined = 0;
    for k in 0..60 {
        good.advance(k as f64 / 60.0, 1.0 / 60.0);
        quarantined = bad.advance(k as f64 / 60.0, 1.0 / 60.0).quarantined;
    }
    let same = good.positions()[..count] == bad.positions()[..count];
    let stands = bad.world.is_quarantined(victim) == Ok(true);
    Verdict {
        passes: states && parameters && steps && quarantined == 1 && stands && same,
        text: format!(
            "state refused {states}, parameter {parameters}, h {steps}; force: {quarantined} quarantined, the other island the same bits: {same}"
        ),
    }
}

fn garbage(_: bool) -> Verdict {
    let mut ends = Vec::new();
    for what in ["position", "velocity", "spin", "stiffness"] {
        let mut scene = c10(1e6);
        let body = scene.bodies[4];
        let mut state = scene.world.rigid(body).expect("a body");
        let mut refused = false;
        match what {
            "position" => state.position.x = 1e300,
            "velocity" => state.velocity.x = 1e300,
            "spin" => state.angular_velocity.x = 1e300,
            _ => {
                let params = point_to_point::Params {
                    arm_a: [1.0; 3],
                    arm_b: [0.0; 3],
                    stiffness: 1e300,
                    damping: 1e300,
                };
                refused |= scene.world.add(params, [scene.bodies[3], body]).is_err();
            }
        }
        refused |= scene.world.set_rigid(body, state).is_err();
        let report = scene.world.step(1.0 / 60.0);
        let quarantined = report.as_ref().is_ok_and(|report: &Report| report.quarantined == 1);
        let finite = scene.positions().iter().all(|x| x.iter().all(|x| x.is_finite()));
        ends.push((what, refused || quarantined || report.is_err(), finite));
    }
    let text = ends.iter().map(|(what, caught, finite)| format!("{what}: caught {caught}, finite {finite}"));
    Verdict {
        passes: ends.iter().all(|(_, caught, finite)| *caught && *finite),
        text: text.collect::<Vec<_>>().join("; "),
    }
}

/// The largest gap of the base chain in single precision, m.
fn single_gap(origin: [f64; 3], stiffness: f64, h: f64, time: f64) -> f64 {
    let mut world = World::<f32>::default();
    world.gravity = Vector3::new(0.0, 0.0, -9.81);
    let origin = Vector3::from(origin);
    let mut last = (world.add_rigid_at(origin, RigidF32::default(), Motion::Kinematic).expect("a pin"), 0.0);
    let inertia = box_inertia(1.0, ROD);
    for k in 0..10 {
        let spin = Vector3::new(3.0, 0.0, 0.5_f32);
        let position = Vector3::new(0.25 + 0.5 * k as f32, 0.0, 0.0);
        let state = RigidF32 {
            position,
            velocity: spin.cross(&position),
            angular_velocity: spin,
            ..RigidF32::default()
        };
        let motion = Motion::Dynamic(1.0, inertia.map(|moment| moment as f32));
        let body = world.add_rigid_at(origin, state, motion).expect("a rod");
        let moving = if k == 0 { 1.0 } else { 2.0 };
        let damping = 2.0 * (stiffness / (moving * (1.0 + 0.0625 / inertia.z))).sqrt();
        let params = point_to_point_f32::Params {
            arm_a: [last.1, 0.0, 0.0],
            arm_b: [-0.25, 0.0, 0.0],
            stiffness: stiffness as f32,
            damping: damping as f32,
        };
        world.add(params, [last.0, body]).expect("a joint");
        last = (body, 0.25);
    }
    let steps = (time / h).round() as usize;
    (0..steps)
        .map(|_| world.step(h as f32).map_or(f64::NAN, |report| report.gap))
        .fold(0.0, |most, gap| if gap.is_nan() { gap } else { most.max(gap) })
}

fn single_far(quick: bool) -> Verdict {
    let gap = |far: f64, stiffness| single_gap([far, -far, far], stiffness, 1.0 / 120.0, time(quick));
    let pairs = [(gap(0.0, 1e6), gap(1e3, 1e6)), (gap(0.0, 1e8), gap(1e5, 1e8))];
    let text = pairs.map(|(near, far)| format!("{near:.4e} → {far:.4e} m"));
    Verdict { passes: pairs.iter().all(|(near, far)| *far <= 1.1 * near), text: text.join(", ") }
}

fn kick(_: bool) -> Verdict {
    let mut scene = c10(1e6);
    let body = scene.bodies[4];
    let load = |torque| Wrench { force: Vec3::zeros(), torque };
    scene.world.set_load(body, load(Vec3::new(0.0, 1e6, 0.0))).expect("a load");
    let first = scene.world.step(1.0 / 120.0).expect("a step");
    scene.world.set_load(body, load(Vec3::zeros())).expect("a load");
    let seen = watch(&mut scene, 5.0, |_| 1.0 / 120.0);
    let backups = first.semi_definite + first.capped + seen.backups;
    Verdict {
        passes: first.quarantined == 0 && backups == 0 && seen.is_stable() && seen.last_gap < 0.01,
        text: format!(
            "{} discarded in the step, then {seen}; at the end gap {:.1e} m",
            first.rejected, seen.last_gap
        ),
    }
}

fn cuts(quick: bool) -> Verdict {
    let run = |seed: Option<u64>| {
        let mut scene = Chain { rods: 500, ..Chain::default() }.scene();
        scene.world.settings.decoupling = seed.map(|seed| Decoupling { limit: 50, seed });
        watch(&mut scene, if quick { 0.1 } else { 1.0 }, |_| 1e-3)
    };
    let whole = run(None);
    let seeds = if quick { 3 } else { 20 };
    let seen: Vec<Seen> = (1..=seeds).map(|seed| run(Some(seed))).collect();
    let same = run(Some(1)).hash == seen[0].hash;
    let worst = seen.iter().map(|seen| seen.gap).fold(0.0, f64::max);
    let stable = seen.iter().all(|seen| seen.finite && seen.quarantined == 0);
    Verdict {
        passes: stable && same && worst <= 3.0 * whole.gap,
        text: format!("gap {:.2e} m, cut at most {worst:.2e} m; same bits {same}; {}", whole.gap, seen[0]),
    }
}

fn threads(quick: bool) -> Verdict {
    let run = || {
        let mut scene = crate::scenes::robots(if quick { 4 } else { 25 }, 1e6, true);
        watch(&mut scene, 0.5, |_| 1.0 / 60.0).hash
    };
    let hashes = [1, 2, 8].map(|threads| {
        #[cfg(feature = "rayon")]
        {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map_or(0, |pool| pool.install(run))
        }
        #[cfg(not(feature = "rayon"))]
        {
            let _ = threads;
            run()
        }
    });
    let same = hashes.iter().all(|hash| *hash == hashes[0]);
    Verdict {
        passes: same && cfg!(feature = "rayon"),
        text: format!("{:016x} {:016x} {:016x}", hashes[0], hashes[1], hashes[2]),
    }
}

fn sleepers(quick: bool) -> Verdict {
    let mut scene = Chain { mass: |_, _| 1.0, ..Chain::default() }.scene();
    let body = scene.bodies[0];
    let before = scene.world.energy();
    for _ in 0..if quick { 1_000 } else { 10_000 } {
        scene.world.sleep(body).expect("a body");
        scene.world.step(1.0 / 60.0).expect("a step");
        scene.world.wake(body).expect("a body");
    }
    let change = (scene.world.energy() - before).abs();
    let mut robots = crate::scenes::robots(100, 1e6, false);
    let cost = |scene: &mut Scene| {
        let started = std::time::Instant::now();
        for _ in 0..20 {
            scene.world.step(1.0 / 240.0).expect("a step");
        }
        started.elapsed().as_secs_f64()
    };
    cost(&mut robots);
    let awake = cost(&mut robots);
    for &body in &robots.bodies.clone() {
        robots.world.sleep(body).expect("a body");
    }
    cost(&mut robots);
    let asleep = cost(&mut robots) / awake;
    Verdict {
        passes: change <= 1e-6 && asleep < 0.02,
        text: format!("energy within {change:.1e} J; asleep {:.4} of awake", asleep),
    }
}

/// The deepest that a stack of cubes sinks in, the top one `top` times as heavy, m.
fn stack(count: usize, top: f64, time: f64) -> f64 {
    let h = 1.0 / 240.0;
    let mut scene = Scene::new(time, h);
    let mut collisions = Collisions::default();
    let ground = scene.world.add_rigid(Rigid::default(), Motion::Kinematic).expect("a floor");
    collisions.add(ground, SharedShape::halfspace(Vector::Z), Surface::default());
    for k in 0..count {
        let mass = if k + 1 == count { top } else { 1.0 } * 1e3;
        let half = [0.5; 3];
        let position = Vec3::new(0.0, 0.0, 0.5 + k as f64);
        let cube = scene.rigid(Rigid { position, ..Rigid::default() }, mass, box_inertia(mass, half), half);
        collisions.add(cube, SharedShape::cuboid(0.5, 0.5, 0.5), Surface::default());
    }
    let mut depth = 0.0_f64;
    for _ in 0..(time / h).round() as usize {
        match collisions.update(&mut scene.world, h) {
            Ok(contacts) => depth = depth.max(contacts.depth),
            Err(_) => return f64::INFINITY,
        }
        scene.world.step(h).expect("a step that is positive and finite");
    }
    depth
}

fn boxes(quick: bool) -> Verdict {
    let time = if quick { 2.0 } else { 60.0 };
    let (one, ten) = (stack(1, 1.0, time), stack(10, 100.0, time));
    Verdict {
        passes: one.max(ten) <= 0.01,
        text: format!("at 1/240 s the box sinks in by {one:.1e} m, the stack by {ten:.1e} m"),
    }
}

fn flipped(_: bool) -> Verdict {
    let library = crate::library();
    let source =
        library.iter().find(|source| source.name.ends_with("joints.rs")).expect("the file of joints");
    let compiled = crate::compile_all(source);
    let function = compiled
        .functions
        .iter()
        .find(|stages| stages.kernel.name == "point_to_point")
        .expect("the ball joint");
    let (mut caught, mut tried, mut name) = (0, 0, String::new());
    for mutation in forcec::verify::mutations(&function.program) {
        if !matches!(mutation, forcec::verify::Mutation::Output(_)) {
            continue;
        }
        let mutant = forcec::verify::apply(&function.program, mutation);
        let subject = forcec::verify::Subject { source: &function.source, program: &mutant };
        let report = forcec::verify::check(&subject, &forcec::verify::CheckOptions { seed: 1, states: 1 });
        tried += 1;
        if let (false, Some(entry)) = (report.passed, report.worst_failure()) {
            caught += 1;
            name.clone_from(&entry.name);
        }
    }
    Verdict {
        passes: tried > 0 && caught == tried,
        text: format!("{caught} of {tried} caught, the last as `{name}`"),
    }
}
