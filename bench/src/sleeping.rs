//! Cost of sleeping robots: the time per step of some freely turning robots, alone, and together with many
//! sleeping robots.

use crate::kernels::Spread;
use crate::scenes::robots;
use std::time::Instant;

/// Times per step, s, of two worlds stepped in turn.
#[derive(Clone, Copy, Debug)]
pub struct Sleeping {
    /// The number of awake robots, in each world.
    pub awake: usize,
    /// The number of sleeping robots in the second world.
    pub asleep: usize,
    /// Times of the first world.
    pub alone: Spread,
    /// Times of the second world.
    pub together: Spread,
    /// Ratio of the second world's time to the first world's time, step by step.
    pub ratio: Spread,
}

/// The step, s.
const STEP: f64 = 1.0 / 120.0;

/// Steps both worlds by turns, `steps` times.
pub fn measure(awake: usize, asleep: usize, steps: usize) -> Sleeping {
    let mut alone = robots(awake, 1e7, false);
    let mut together = robots(awake + asleep, 1e7, false);
    let links = alone.bodies.len() / awake;
    for robot in together.bodies.chunks_exact(links).skip(awake) {
        together.world.sleep(robot[0]).expect("a body of the scene");
    }
    let mut times = [const { Vec::new() }; 2];
    for _ in 0..steps {
        for (scene, times) in [&mut alone, &mut together].into_iter().zip(&mut times) {
            let started = Instant::now();
            scene.world.step(STEP).expect("a step that is positive and finite");
            times.push(started.elapsed().as_secs_f64());
        }
    }
    let ratio =
        Spread::of(times[0].iter().zip(&times[1]).map(|(alone, together)| together / alone).collect());
    let [alone, together] = times.map(Spread::of);
    Sleeping { awake, asleep, alone, together, ratio }
}

/// Times as a table.
pub fn table(all: &[Sleeping]) -> String {
    let mut text = String::from(
        "| robots awake | robots asleep | µs per step without the sleeping | µs per step with the sleeping | ratio | quartiles |\n|--:|--:|--:|--:|--:|--:|\n",
    );
    for one in all {
        text += &format!(
            "| {} | {} | {:.0} | {:.0} | {:.3} | {:.3} … {:.3} |\n",
            one.awake,
            one.asleep,
            one.alone.median * 1e6,
            one.together.median * 1e6,
            one.ratio.median,
            one.ratio.low,
            one.ratio.high
        );
    }
    text
}
