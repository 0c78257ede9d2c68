//! `precision`: run time against error of whole simulations, a row an integrator and a step.
//!
//! The error is the root of the mean square distance of all bodies, at the end, from a reference: of the chain the same
//! scene, of the robots the scene with joints a thousand times stiffer, so that compliance is part of the error. References
//! are computed with [`Integrator::Rodas4`] and a tolerance far below what is measured; beside each stands how far it is
//! from one that is coarser.

use crate::run::INTEGRATORS;
use crate::scenes::{Scene, c10, robots};
use forcec_runtime::Integrator;
use forcec_runtime::prelude::Vec3;
use std::time::Instant;

/// A scene whose end is known.
pub struct Problem {
    /// Its name.
    pub name: &'static str,
    make: fn() -> Scene,
    /// One that ends where it should, by how fine it is: 0 and 1.
    reference: fn(usize) -> Scene,
    /// The steps of the references, s.
    reference_steps: [f64; 2],
}

/// The problems.
pub const PROBLEMS: [Problem; 3] = [
    Problem { name: "c10", make: || c10(1e6), reference: |_| c10(1e6), reference_steps: [1e-4, 5e-5] },
    Problem {
        name: "c10, ks 1e8",
        make: || c10(1e8),
        reference: |_| c10(1e8),
        reference_steps: [1e-4, 5e-5],
    },
    Problem {
        name: "ben25",
        make: || robots(25, 1e7, true),
        reference: |fine| robots(1, [1e9, 1e10][fine], true),
        reference_steps: [2e-4, 1e-4],
    },
];

/// One integrator with one step.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The integrator's name.
    pub integrator: &'static str,
    /// The step, s.
    pub h: f64,
    /// Time of a step, s, the least of three runs.
    pub step: f64,
    /// Of the positions at the end, m; none if an island stood still or all was lost.
    pub error: Option<f64>,
    /// Steps that were discarded, of all.
    pub rejected: (usize, usize),
}

/// The steps that are tried, s.
pub const STEPS: [f64; 8] =
    [1.0 / 30.0, 1.0 / 60.0, 1.0 / 120.0, 1.0 / 240.0, 1.0 / 480.0, 1e-3, 5e-4, 2.5e-4];

/// All points of a problem, and how far its reference is from a coarser one, m.
pub fn measure(problem: &Problem, steps: &[f64]) -> (Vec<Point>, f64) {
    let reference = |fine: usize| {
        let mut scene = (problem.reference)(fine);
        scene.world.settings.integrator = Integrator::Rodas4;
        scene.world.settings.tolerance = 1e-10;
        end(&mut scene, problem.reference_steps[fine]).0
    };
    let (coarse, fine) = (reference(0), reference(1));
    let mut points = Vec::new();
    for (name, integrator) in INTEGRATORS {
        for &h in steps {
            let (mut least, mut error, mut rejected) = (f64::INFINITY, None, (0, 0));
            for _ in 0..3 {
                let mut scene = (problem.make)();
                scene.world.settings.integrator = integrator;
                let (positions, time, discarded, all) = end(&mut scene, h);
                least = least.min(time);
                rejected = (discarded, all);
                error = Some(distance(&positions, &fine)).filter(|error| error.is_finite());
                let stands = scene.bodies.iter().any(|&body| scene.world.is_quarantined(body) == Ok(true));
                error = error.filter(|_| !stands);
            }
            points.push(Point { integrator: name, h, step: least, error, rejected });
        }
    }
    (points, distance(&coarse, &fine))
}

/// Runs a scene to its end: positions, seconds a step, steps discarded and steps in all.
fn end(scene: &mut Scene, h: f64) -> (Vec<Vec3>, f64, usize, usize) {
    let steps = (scene.time / h).round() as usize;
    let (mut rejected, mut accepted) = (0, 0);
    let started = Instant::now();
    for k in 0..steps {
        let report = scene.advance(k as f64 * h, h);
        rejected += report.rejected;
        accepted += report.accepted;
    }
    let time = started.elapsed().as_secs_f64() / steps.max(1) as f64;
    (scene.positions(), time, rejected, rejected + accepted)
}

/// Root of the mean square distance; bodies beyond those of the reference are further copies of its scene, moved.
fn distance(positions: &[Vec3], reference: &[Vec3]) -> f64 {
    let squares = positions.chunks_exact(reference.len()).flat_map(|copy| {
        // Copies are 3 m apart.
        let shift = (copy[0] - reference[0]).map(|x| (x / 3.0).round() * 3.0);
        copy.iter().zip(reference).map(move |(a, b)| (a - b - shift).norm_squared())
    });
    (squares.sum::<f64>() / positions.len() as f64).sqrt()
}

/// The table of a problem.
pub fn table(problem: &Problem, points: &[Point], own: f64) -> String {
    let mut text = format!(
        "{}; the reference differs by {own:.1e} m from a coarser one\n\n\
         | integrator | step, s | µs a step | ms a simulated second | error, m | discarded |\n|---|--:|--:|--:|--:|--:|\n",
        problem.name
    );
    for point in points {
        let error = point.error.map_or("lost".to_owned(), |error| format!("{error:.2e}"));
        text += &format!(
            "| {} | {:.2e} | {:.1} | {:.2} | {error} | {} of {} |\n",
            point.integrator,
            point.h,
            point.step * 1e6,
            point.step / point.h * 1e3,
            point.rejected.0,
            point.rejected.1
        );
    }
    text
}
