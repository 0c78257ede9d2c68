//! Cost of sleeping robots: the time per step of some freely turning robots, alone, and together with many
//! sleeping robots.

use crate::kernels::Spread;
use crate::scenes::robots;
use std::time::Instant;

/// Times per step, s, of two worlds stepped in turn.
#[derive(Clone, Copy, Debug)]
pub struct Sleeping {
    /// How many robots are awake in both worlds.
    pub awake: usize,
    /// How many more are asleep in the second.
    pub asleep: usize,
    /// Times of the first world.
    pub alone: Spread,
    /// Times of the second world.
    pub beside: Spread,
    /// Ratio of the second world's time to the first world's time, step by step.
    pub ratio: Spread,
}

/// The step, s.
const STEP: f64 = 1.0 / 120.0;

/// Steps both worlds by turns, `steps` times.
pub fn measure(awake: usize, asleep: usize, steps: usize) -> Sleeping {
    let mut alone = robots(awake, 1e7, false);
    let mut beside = robots(awake + asleep, 1e7, false);
    let links = alone.bodies.len() / awake;
    for robot in beside.bodies.chunks_exact(links).skip(awake) {
        beside.world.sleep(robot[0]).expect("a body of the scene");
    }
    let mut times = [const { Vec::new() }; 2];
    for _ in 0..steps {
        for (scene, times) in [&mut alone, &mut beside].into_iter().zip(&mut times) {
            let started = Instant::now();
            scene.world.step(STEP).expect("a step that is positive and finite");
            times.push(started.elapsed().as_secs_f64());
        }
    }
    let ratio = Spread::of(times[0].iter().zip(&times[1]).map(|(alone, beside)| beside / alone).collect());
    let [alone, beside] = times.map(Spread::of);
    Sleeping { awake, asleep, alone, beside, ratio }
}

/// Times as a table.
pub fn table(all: &[Sleeping]) -> String {
    let mut text = String::from(
        "| robots awake | robots asleep beside them | µs a step alone | µs a step beside them | ratio | quartiles |\n|--:|--:|--:|--:|--:|--:|\n",
    );
    for one in all {
        text += &format!(
            "| {} | {} | {:.0} | {:.0} | {:.3} | {:.3} … {:.3} |\n",
            one.awake,
            one.asleep,
            one.alone.median * 1e6,
            one.beside.median * 1e6,
            one.ratio.median,
            one.ratio.low,
            one.ratio.high
        );
    }
    text
}
