//! Points of run time against error.

use super::Options;
use super::peers::Row;
use super::problems::{Judged, Problem, Reference};
use crate::run::INTEGRATORS;
use crate::scenes::Scene;
use cpu_time::ThreadTime;
use forcec_runtime::Integrator;
use forcec_runtime::prelude::Vec3;
use std::time::Duration;

/// The tested step sizes, s.
const STEPS: [f64; 9] =
    [1.0 / 30.0, 1.0 / 60.0, 1.0 / 120.0, 1.0 / 240.0, 1.0 / 480.0, 1e-3, 5e-4, 2.5e-4, 1e-4];

/// Tolerances per step for methods with error control, m, in frames of 1/60 s; the default is among them.
const TOLERANCES: [f64; 8] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// Number of measurements per point, unless one takes longer than half a second.
const ROUNDS: usize = 5;

/// All measurements of a problem.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Points, maker by maker.
    pub points: Vec<Point>,
    /// The reference of the error.
    pub reference: String,
}

/// A stepping method of one maker, and its results.
#[derive(Clone, Debug)]
pub struct Point {
    /// The integrator, or the engine and its settings.
    pub maker: String,
    /// Whether the maker is a peer.
    pub is_peer: bool,
    /// The step, s.
    pub h: f64,
    /// The tolerance of a method that chooses its steps within `h`, m.
    pub tolerance: Option<f64>,
    /// Processor time per step, s, the least of some runs.
    pub step: f64,
    /// The error.
    pub error: f64,
    /// Number of discarded steps, and of all steps.
    pub rejected: (usize, usize),
    /// Usability of the point.
    pub state: State,
}

/// Usability of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// All steps had the requested size.
    Plain,
    /// Step control discarded some steps, and took smaller ones.
    Shortened,
    /// Error control chose all steps.
    Controlled,
    /// The error is larger than the error of no motion, or is not finite.
    Diverged,
    /// An island was put in quarantine.
    Quarantined,
}

impl State {
    /// Whether the result is usable.
    pub fn is_sound(self) -> bool {
        !matches!(self, State::Diverged | State::Quarantined)
    }

    /// A one-word description; empty if unnecessary.
    pub fn word(self) -> &'static str {
        match self {
            State::Plain | State::Controlled => "",
            State::Shortened => "shortened",
            State::Diverged => "diverged",
            State::Quarantined => "quarantined",
        }
    }
}

impl Point {
    /// Time per simulated second, ms.
    pub fn cost(&self) -> f64 {
        self.step / self.h * 1e3
    }
}

/// A stepping method.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    integrator: Integrator,
    h: f64,
    tolerance: Option<f64>,
}

/// Each integrator at each step, or at each tolerance.
fn ways(options: &Options) -> Vec<Way> {
    let quick = options.quick;
    let steps = if quick { &STEPS[1..3] } else { &STEPS[..] };
    let tolerances = if quick { &TOLERANCES[2..4] } else { &TOLERANCES[..] };
    let each = INTEGRATORS
        .into_iter()
        .filter(|(_, it)| options.integrators.is_empty() || options.integrators.contains(it))
        .flat_map(|(name, integrator)| match integrator {
            Integrator::Rodas4 => {
                let way = |&tolerance| Way { name, integrator, h: 1.0 / 60.0, tolerance: Some(tolerance) };
                tolerances.iter().map(way).collect::<Vec<Way>>()
            }
            _ => steps.iter().map(|&h| Way { name, integrator, h, tolerance: None }).collect(),
        });
    each.collect()
}

/// Results of a run.
struct End {
    /// The values from which the error is computed.
    marks: Vec<Vec3>,
    /// The largest change of energy, J.
    drift: f64,
    time: Duration,
    rejected: (usize, usize),
    quarantined: bool,
}

/// All points of a problem, ours and those of peers. Runs that would take longer than the budget are left out. Rounds are
/// interleaved: in each, every way has its turn.
pub fn measure(problem: &Problem, peers: &[Row], options: &Options) -> Measured {
    crate::on_threads(1, || single(problem, peers, options))
}

fn single(problem: &Problem, peers: &[Row], options: &Options) -> Measured {
    let (quick, budget) = (options.quick, options.budget * problem.cost_factor);
    let known = Known::of(problem, peers);
    let ways = ways(options);
    let mut points: Vec<Option<Point>> = vec![None; ways.len()];
    for round in 0..if quick { 1 } else { ROUNDS } {
        for (way, point) in ways.iter().zip(&mut points) {
            let long = |point: &Point| point.step * (known.time / point.h) > 0.5;
            if round > 0 && point.as_ref().is_none_or(long) {
                continue;
            }
            let mut scene = (problem.make)();
            scene.world.settings.integrator = way.integrator;
            scene.world.settings.tolerance = way.tolerance.unwrap_or(scene.world.settings.tolerance);
            let Some(end) = end(&mut scene, way.h, known.marks, budget) else { continue };
            let step = end.time.as_secs_f64() / (scene.time / way.h).round();
            match point {
                Some(point) => point.step = point.step.min(step),
                None => *point = Some(known.point(way, &end, step)),
            }
        }
    }
    let ours = points.into_iter().flatten();
    let theirs = peers.iter().filter(|row| Some(row.scene.as_str()) == problem.peers && !row.is_reference());
    let theirs = theirs.map(|row| known.peer(row)).collect::<Vec<Point>>();
    Measured { points: ours.chain(theirs).collect(), reference: known.text }
}

/// The known final state of a problem.
struct Known {
    /// Final state of one copy; empty where energy is judged.
    end: Vec<Vec3>,
    /// The error if nothing moved.
    moved: f64,
    copies: usize,
    time: f64,
    marks: fn(&Scene) -> Vec<Vec3>,
    text: String,
}

impl Known {
    fn of(problem: &Problem, peers: &[Row]) -> Known {
        let scene = (problem.make)();
        let copies = problem.copies;
        let mut known = Known {
            end: Vec::new(),
            moved: f64::INFINITY,
            copies,
            time: scene.time,
            marks: Scene::positions,
            text: "energy at the start".to_owned(),
        };
        let Judged::End(reference) = &problem.judged else {
            known.moved = scene.world.energy().abs() / copies as f64;
            return known;
        };
        let [coarse, fine] = [0, 1].map(|fine| refer(reference, fine));
        known.marks = reference.marks;
        let [first, second] = reference.steps;
        let own = distance(&coarse, &fine);
        known.text =
            format!("{:?} at {second:e} s, {own:.1e} m from one at {first:e} s", reference.integrator);
        // An engine with rigid joints gives a more accurate reference than stiff joints.
        let theirs: Vec<&Row> = peers
            .iter()
            .filter(|row| Some(row.scene.as_str()) == problem.peers && row.is_reference())
            .collect();
        known.end = match theirs[..] {
            [one, other, ..] => {
                let text = format!(
                    "{} {} at {:e} s, rigid, {:.1e} m from one at {:e} s; ours with joints of 1e10 N/m is {:.1e} m from it",
                    one.engine,
                    one.version,
                    one.h,
                    distance(&one.positions, &other.positions),
                    other.h,
                    distance(&one.positions, &fine)
                );
                known.text = text;
                one.positions.clone()
            }
            _ => fine,
        };
        known.moved = distance(&(reference.marks)(&scene), &known.end);
        known
    }

    fn error(&self, marks: &[Vec3], drift: f64) -> f64 {
        if self.end.is_empty() { drift / self.copies as f64 } else { distance(marks, &self.end) }
    }

    fn point(&self, way: &Way, end: &End, step: f64) -> Point {
        let error = self.error(&end.marks, end.drift);
        let state = match (end.quarantined, error < self.moved, way.tolerance, end.rejected.0) {
            (true, ..) => State::Quarantined,
            (_, false, ..) => State::Diverged,
            (_, _, Some(_), _) => State::Controlled,
            (_, _, None, 0) => State::Plain,
            (_, _, None, _) => State::Shortened,
        };
        Point {
            maker: way.name.to_owned(),
            is_peer: false,
            h: way.h,
            tolerance: way.tolerance,
            step,
            error,
            rejected: end.rejected,
            state,
        }
    }

    fn peer(&self, row: &Row) -> Point {
        let error = if self.end.is_empty() { row.drift } else { distance(&row.positions, &self.end) };
        Point {
            maker: format!("{} {}", row.engine, row.setting),
            is_peer: true,
            h: row.h,
            tolerance: None,
            step: row.step,
            error,
            rejected: (0, 0),
            state: if error < self.moved { State::Plain } else { State::Diverged },
        }
    }
}

fn refer(reference: &Reference, fine: usize) -> Vec<Vec3> {
    let mut scene = (reference.make)(fine);
    scene.world.settings.integrator = reference.integrator;
    scene.world.settings.tolerance = 1e-10;
    let end = end(&mut scene, reference.steps[fine], reference.marks, f64::INFINITY);
    end.expect("a run without a limit").marks
}

/// Runs a scene to its end; `None` if the run would take longer than `budget`, s.
fn end(scene: &mut Scene, h: f64, marks: fn(&Scene) -> Vec<Vec3>, budget: f64) -> Option<End> {
    let steps = (scene.time / h).round() as usize;
    let start = scene.world.energy();
    let mut end =
        End { marks: Vec::new(), drift: 0.0, time: Duration::ZERO, rejected: (0, 0), quarantined: false };
    for k in 0..steps {
        let started = ThreadTime::now();
        let report = scene.advance(k as f64 * h, h);
        end.time += started.elapsed();
        end.drift = end.drift.max((report.energy - start).abs());
        end.rejected.0 += report.rejected;
        end.rejected.1 += report.rejected + report.accepted;
        end.quarantined |= report.quarantined > 0;
        // The first steps include set-up, and are not representative.
        if k >= steps / 20 && end.time.as_secs_f64() * steps as f64 > budget * (k + 1) as f64 {
            return None;
        }
    }
    end.marks = marks(scene);
    Some(end)
}

/// Root of the mean square distance; marks beyond those of the reference are further copies of it, 3 m apart.
fn distance(marks: &[Vec3], reference: &[Vec3]) -> f64 {
    let squares = marks.chunks_exact(reference.len()).flat_map(|copy| {
        let shift = (copy[0] - reference[0]).map(|x| (x / 3.0).round() * 3.0);
        copy.iter().zip(reference).map(move |(a, b)| (a - b - shift).norm_squared())
    });
    (squares.sum::<f64>() / marks.len() as f64).sqrt()
}
