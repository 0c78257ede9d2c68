//! What robots that sleep cost: the time of a step of some robots that turn freely, alone, and beside many that are asleep.

use crate::scenes::robots;
use std::time::Instant;

/// Times of a step, s: the least of each round's, the two worlds stepped by turns.
#[derive(Clone, Copy, Debug)]
pub struct Sleeping {
    /// How many robots are awake in both worlds.
    pub awake: usize,
    /// How many more are asleep in the second.
    pub asleep: usize,
    /// A step of the first.
    pub alone: f64,
    /// A step of the second.
    pub beside: f64,
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
    let mut least = [f64::INFINITY; 2];
    for _ in 0..steps {
        for (scene, least) in [&mut alone, &mut beside].into_iter().zip(&mut least) {
            let started = Instant::now();
            scene.world.step(STEP).expect("a step that is positive and finite");
            *least = least.min(started.elapsed().as_secs_f64());
        }
    }
    Sleeping { awake, asleep, alone: least[0], beside: least[1] }
}

/// The row of a table.
pub fn table(all: &[Sleeping]) -> String {
    let mut text = String::from(
        "| robots awake | robots asleep beside them | µs a step alone | µs a step beside them | ratio |\n|--:|--:|--:|--:|--:|\n",
    );
    for one in all {
        text += &format!(
            "| {} | {} | {:.0} | {:.0} | {:.3} |\n",
            one.awake,
            one.asleep,
            one.alone * 1e6,
            one.beside * 1e6,
            one.beside / one.alone
        );
    }
    text
}
