//! Islands that are cut, spread over threads, or asleep.

use super::{Seen, Verdict, watch};
use crate::scenes::{Chain, Scene, c10, robots};
use forcec_runtime::Decoupling;

pub(super) fn cuts(quick: bool) -> Verdict {
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

pub(super) fn threads(quick: bool) -> Verdict {
    let run = || watch(&mut robots(if quick { 4 } else { 25 }, 1e6, true), 0.5, |_| 1.0 / 60.0).hash;
    let hashes = [1, 2, 8].map(|threads| crate::on_threads(threads, run));
    let same = hashes.iter().all(|hash| *hash == hashes[0]);
    Verdict {
        passes: same && cfg!(feature = "rayon"),
        text: format!("{:016x} {:016x} {:016x}", hashes[0], hashes[1], hashes[2]),
    }
}

pub(super) fn sleepers(quick: bool) -> Verdict {
    let mut scene = c10(1e6);
    let body = scene.bodies[0];
    let before = scene.world.energy();
    for _ in 0..if quick { 1_000 } else { 10_000 } {
        scene.world.sleep(body).expect("a body");
        scene.world.step(1.0 / 60.0).expect("a step");
        scene.world.wake(body).expect("a body");
    }
    let change = (scene.world.energy() - before).abs();
    let mut robots = robots(100, 1e6, false);
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
