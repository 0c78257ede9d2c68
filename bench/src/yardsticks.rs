//! `yardsticks`: mechanisms of rigid joints against published or exact solutions.
//!
//! In: the rows of [`YARDSTICKS`]. Out: a table. The error is the largest of the compared
//! values, m or rad; the energy is the largest change that no load explains; time is that of the one thread.

use crate::on_threads;
use crate::scenes::{ANDREWS_TORQUE, Scene, andrews, bricard, four_bars, pendulum, ring};
use cpu_time::ThreadTime;
use forcec_runtime::Integrator::{self, RungeKutta4, Sdirk2};
use forcec_runtime::prelude::Vec3;
use std::f64::consts::TAU;
use std::fmt::Write;

/// A method with a step, s, and a tolerance for `RungeKutta4`, m.
pub type Way = (Integrator, f64, f64);

/// A scene with a known solution.
pub struct Yardstick {
    /// Name of the scene.
    pub name: &'static str,
    /// Creates the scene.
    pub make: fn() -> Scene,
    /// The values compared at the end.
    marks: fn(&Scene) -> Vec<f64>,
    /// What these values should be; empty if only energy is known. Angles are compared up to full turns.
    reference: &'static [f64],
    /// Whether the values are angles, rad, and not places, m.
    angles: bool,
    /// A constant torque on the first body, N·m.
    torque: Vec3,
    /// The methods to try, the cheapest that reaches the goal first.
    pub ways: &'static [Way],
}

/// The end of a run.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// The largest error, m or rad; `None` without a reference.
    pub error: Option<f64>,
    /// The largest change of energy, less the work of the torque, J.
    pub energy: f64,
    /// The largest violation of a constraint, m or rad; that of a spring is its stretch.
    pub gap: f64,
    /// Processor time, ms.
    pub time: f64,
    /// Accepted and discarded steps, and islands in quarantine.
    pub steps: (usize, usize, usize),
}

const FIXED: f64 = f64::INFINITY;

/// The scenes.
pub static YARDSTICKS: [Yardstick; 6] = [
    Yardstick {
        name: "pendulum",
        make: pendulum,
        marks: |scene| scene.positions().iter().flat_map(|at| [at.x, at.y]).collect(),
        reference: &[-0.275_087_462_576_116_9, -0.961_419_205_099_125_1],
        angles: false,
        torque: Vec3::new(0.0, 0.0, 0.0),
        ways: &[(RungeKutta4, 1.0 / 60.0, FIXED), (RungeKutta4, 1e-2, FIXED), (Sdirk2, 5e-3, FIXED)],
    },
    Yardstick {
        name: "2 four-bar linkages",
        make: || four_bars(2),
        marks: top,
        reference: &[0.328_458_111_540_815_4, 0.944_518_538_178_601],
        angles: false,
        torque: Vec3::new(0.0, 0.0, 0.0),
        ways: &[(RungeKutta4, 2e-2, FIXED), (RungeKutta4, 5e-3, FIXED)],
    },
    Yardstick {
        name: "40 four-bar linkages",
        make: || four_bars(40),
        marks: top,
        reference: &[0.180_512_226_686_728_4, 0.983_572_740_582_311_6],
        angles: false,
        torque: Vec3::new(0.0, 0.0, 0.0),
        ways: &[(RungeKutta4, 4e-2, FIXED), (RungeKutta4, 1e-2, FIXED), (Sdirk2, 1e-2, FIXED)],
    },
    Yardstick {
        name: "Bricard's mechanism",
        make: bricard,
        marks: |_| Vec::new(),
        reference: &[],
        angles: false,
        torque: Vec3::new(0.0, 0.0, 0.0),
        ways: &[(RungeKutta4, 2e-2, FIXED), (RungeKutta4, 5e-3, FIXED), (Sdirk2, 5e-3, FIXED)],
    },
    Yardstick {
        name: "squeezing mechanism",
        make: andrews,
        marks: squeezed,
        reference: &[
            15.810_771_196_299_04,
            -15.756_371_059_842_98,
            0.040_822_240_133_731_01,
            -0.534_730_116_322_694_8,
            0.524_409_965_880_530_4,
            0.534_730_116_322_694_8,
            1.048_080_741_042_263,
        ],
        angles: true,
        torque: ANDREWS_TORQUE,
        ways: &[(RungeKutta4, 1e-4, FIXED), (RungeKutta4, 2e-5, FIXED), (Sdirk2, 1e-5, FIXED)],
    },
    Yardstick {
        name: "ring of 100 rods",
        make: rigid_ring,
        marks: |_| Vec::new(),
        reference: &[],
        angles: false,
        torque: Vec3::new(0.0, 0.0, 0.0),
        ways: &[(RungeKutta4, 1.0 / 120.0, 5e-10), (RungeKutta4, 1.0 / 120.0, FIXED)],
    },
];

fn rigid_ring() -> Scene {
    let mut scene = ring(100, f64::INFINITY);
    scene.world.settings.integrator = RungeKutta4;
    scene
}

/// Where the first upright rod ends.
fn top(scene: &Scene) -> Vec<f64> {
    let rod = scene.world.rigid(scene.bodies[0]).expect("a rod");
    let end = rod.position + rod.orientation * Vec3::new(0.5, 0.0, 0.0);
    vec![end.x, end.y]
}

/// β, Θ, γ, Φ, δ, Ω and ε, up to full turns.
fn squeezed(scene: &Scene) -> Vec<f64> {
    let angle = |k: usize| {
        let body = scene.world.rigid(scene.bodies[k]).expect("a link");
        body.orientation.scaled_axis().z
    };
    let [a, b, c, d, e, f, g] = [0, 1, 2, 3, 4, 5, 6].map(angle);
    vec![a, b - a, c, d - e, e, f - g, g]
}

/// Runs a scene by a method, for a time, s, or to its end.
pub fn measure(yardstick: &Yardstick, way: &Way, time: Option<f64>) -> End {
    on_threads(1, || {
        let mut scene = (yardstick.make)();
        let &(integrator, h, tolerance) = way;
        scene.world.settings.integrator = integrator;
        scene.world.settings.tolerance = tolerance;
        let (start, whole) = (scene.world.energy(), time.is_none());
        let mut end = End { error: None, energy: 0.0, gap: 0.0, time: 0.0, steps: (0, 0, 0) };
        let mut work = 0.0;
        let turn = |scene: &Scene| scene.world.rigid(scene.bodies[0]).map(|body| body.orientation).ok();
        for k in 0..(time.unwrap_or(scene.time) / h).round() as usize {
            let before = turn(&scene);
            let started = ThreadTime::now();
            let report = scene.advance(k as f64 * h, h);
            end.time += started.elapsed().as_secs_f64() * 1e3;
            if let (Some(before), Some(after)) = (before, turn(&scene)) {
                work += yardstick.torque.dot(&(after * before.inverse()).scaled_axis());
            }
            end.energy = end.energy.max((report.energy - start - work).abs());
            end.gap = end.gap.max(report.max_violation);
            end.steps.0 += report.accepted;
            end.steps.1 += report.rejected;
            end.steps.2 = report.quarantined;
        }
        let errors = (yardstick.marks)(&scene).into_iter().zip(yardstick.reference).map(|(x, known)| {
            let error = x - known;
            if yardstick.angles { (error - (error / TAU).round() * TAU).abs() } else { error.abs() }
        });
        end.error = if whole { errors.reduce(f64::max) } else { None };
        end
    })
}

/// The table of mechanisms; of the first method alone if `quick`.
pub fn table(quick: bool) -> String {
    let mut text = String::from(
        "| scene | step, s | tolerance, m | method | error, m or rad | energy, J | gap | ms |\n\
         |---|--:|--:|---|--:|--:|--:|--:|\n",
    );
    for yardstick in &YARDSTICKS {
        let tried = if quick { &yardstick.ways[..1] } else { yardstick.ways };
        for way in tried {
            let end = measure(yardstick, way, None);
            let error = end.error.map_or_else(String::new, |error| format!("{error:.1e}"));
            let tolerance = if way.2.is_finite() { format!("{:.0e}", way.2) } else { String::new() };
            let _ = writeln!(
                text,
                "| {} | {:.1e} | {tolerance} | {:?} | {error} | {:.1e} | {:.1e} | {:.1} |",
                yardstick.name, way.1, way.0, end.energy, end.gap, end.time
            );
        }
    }
    text
}
