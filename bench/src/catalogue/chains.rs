//! Chains of rods: stiff, heavy, long, torn, kicked, and stepped unevenly.

use super::{Seen, Verdict, stable, time, watch};
use crate::scenes::{Chain, c10};
use forcec_runtime::prelude::Vec3;
use forcec_runtime::{Integrator, Wrench};

/// Whether a chain is **U** at a step.
pub(super) fn steady(chain: Chain, h: f64, quick: bool) -> Verdict {
    stable(&|| chain.scene(), time(quick), h)
}

pub(super) fn sweep(quick: bool) -> Verdict {
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

pub(super) fn heavy(quick: bool) -> Verdict {
    let chain =
        Chain { stiffness: 1e10, mass: |k, n| if k + 1 == n { 1e6 } else { 1.0 }, ..Chain::default() };
    let mut verdict = steady(chain, 1.0 / 240.0, quick);
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

pub(super) fn long(quick: bool) -> Verdict {
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

pub(super) fn stretched(_: bool) -> Verdict {
    let mut scene = Chain { stretch: 1.0, ..Chain::default() }.scene();
    let seen = watch(&mut scene, 1.0, |_| 1.0 / 120.0);
    Verdict {
        passes: seen.is_stable() && seen.last_gap < 0.01 && seen.last_speed < 100.0,
        text: format!(
            "{seen}; after 1 s gap {:.1e} m, speed {:.1} m/s; speed on the way {:.0} m/s",
            seen.last_gap, seen.last_speed, seen.speed
        ),
    }
}

pub(super) fn pendulum(quick: bool) -> Verdict {
    let steps = if quick { 5_000 } else { 100_000 };
    let (worst, each) = swing(Integrator::Sdirk2, Some(1e-7), steps);
    let (alpha, of_alpha) = swing(Integrator::GeneralizedAlpha, None, steps);
    Verdict {
        passes: worst <= 1e-3,
        text: format!(
            "energy within {worst:.1e} with `energy_loss` 1e-7, {each:.1} steps in 1e-3 s; generalised-α without it {alpha:.1e}, \
             {of_alpha:.1} steps"
        ),
    }
}

/// A double pendulum without damping: the largest change of energy, relative to the larger of the initial
/// energy and the range of kinetic energy, and the number of attempted steps per requested step.
fn swing(integrator: Integrator, loss: Option<f64>, steps: u32) -> (f64, f64) {
    let mut scene = Chain { rods: 2, damping: 0.0, ..Chain::default() }.scene();
    scene.world.settings.integrator = integrator;
    scene.world.settings.energy_loss = loss;
    let start = scene.world.energy();
    let (mut worst, mut least, mut most) = (0.0_f64, f64::MAX, f64::MIN);
    let mut tried = 0;
    for k in 0..steps {
        let report = scene.advance(f64::from(k) * 1e-3, 1e-3);
        let moving = report.energy - scene.potential();
        (least, most) = (least.min(moving), most.max(moving));
        worst = worst.max((report.energy - start).abs());
        tried += report.accepted + report.rejected;
    }
    (worst / start.abs().max(most - least), tried as f64 / f64::from(steps))
}

/// Steps that differ by three orders of magnitude.
pub(super) fn uneven(quick: bool) -> Verdict {
    let seen = watch(&mut c10(1e6), time(quick), |k| if k % 2 == 0 { 1.0 / 60.0 } else { 1e-5 });
    Verdict { passes: seen.is_stable(), text: seen.to_string() }
}

pub(super) fn kick(_: bool) -> Verdict {
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
