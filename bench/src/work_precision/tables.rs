//! Points as tables and as CSV.

use super::measure::{Measured, Point};
use super::problems::Problem;
use std::fmt::Write;

/// The steps of the table, s, with their names.
const FRAMES: [(f64, &str); 2] = [(1.0 / 60.0, "1/60"), (1.0 / 120.0, "1/120")];

/// The tolerance of the table.
const TOLERANCE: f64 = 1e-5;

/// Points maker by maker.
pub(super) fn makers(measured: &Measured) -> Vec<(&str, Vec<&Point>)> {
    let mut makers: Vec<(&str, Vec<&Point>)> = Vec::new();
    for point in &measured.points {
        match makers.iter_mut().find(|(maker, _)| *maker == point.maker) {
            Some((_, points)) => points.push(point),
            None => makers.push((&point.maker, vec![point])),
        }
    }
    makers
}

fn at<'a>(points: &[&'a Point], h: f64) -> Option<&'a Point> {
    points.iter().copied().find(|point| {
        (point.h / h - 1.0).abs() < 1e-6 && point.tolerance.is_none_or(|tolerance| tolerance == TOLERANCE)
    })
}

/// A row a maker: time and error at usual steps, and the least time of a simulated second for errors of at most a power of ten.
pub(super) fn table(problem: &Problem, measured: &Measured) -> String {
    let sound = measured.points.iter().filter(|point| point.state.is_sound() && point.error > 0.0);
    let powers: Vec<i32> = sound.map(|point| point.error.log10().ceil() as i32).collect();
    let high = powers.iter().copied().max().unwrap_or(0);
    // Some columns say enough.
    let targets: Vec<i32> = (0..5).map(|k| high - 1 - k).collect();
    let mut text = format!("Reference: {}.\n\n| |", measured.reference);
    for (_, name) in FRAMES {
        let _ = write!(text, " {name} s: µs a step | {} | |", problem.error());
    }
    targets.iter().for_each(|power| {
        let _ = write!(text, " ms for ≤ 1e{power} |");
    });
    text += &format!("\n|---|{}{}\n", "--:|--:|---|".repeat(FRAMES.len()), "--:|".repeat(targets.len()));
    for (maker, points) in makers(measured) {
        let _ = write!(text, "| {maker} |");
        for (h, _) in FRAMES {
            let _ = match at(&points, h) {
                Some(point) => {
                    write!(text, " {:.1} | {:.1e} | {} |", point.step * 1e6, point.error, point.state.word())
                }
                None => write!(text, " | | |"),
            };
        }
        for &power in &targets {
            let good = points
                .iter()
                .filter(|point| point.state.is_sound() && point.error <= 10.0_f64.powi(power))
                .map(|point| point.cost());
            let _ = match good.min_by(f64::total_cmp) {
                Some(cost) => write!(text, " {} |", three(cost)),
                None => write!(text, " |"),
            };
        }
        text.push('\n');
    }
    text
}

/// A number with about three digits.
fn three(x: f64) -> String {
    let digits = (2.0 - x.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{x:.digits$}")
}

/// Every point.
pub(super) fn csv(problem: &Problem, measured: &Measured) -> String {
    let mut text =
        String::from("scene,maker,h_s,tolerance_m,us_step,ms_second,error,discarded,steps,state\n");
    for point in &measured.points {
        let tolerance = point.tolerance.map_or(String::new(), |tolerance| tolerance.to_string());
        let _ = writeln!(
            text,
            "{},\"{}\",{},{tolerance},{},{},{:e},{},{},{}",
            problem.name,
            point.maker,
            point.h,
            point.step * 1e6,
            point.cost(),
            point.error,
            point.rejected.0,
            point.rejected.1,
            point.state.word()
        );
    }
    text
}

/// For each point of a peer, the fastest of our points with at most its error in position and in energy; `None` without peers.
pub(super) fn compared(all: &[(&Problem, Measured)]) -> Option<String> {
    let of = |name: &str| all.iter().find(|(problem, _)| problem.name == name).map(|(_, measured)| measured);
    let (driven, free) = (of("ben25-rigid")?, of("ben25-rigid-free")?);
    let both: Vec<(&Point, &Point)> = driven
        .points
        .iter()
        .filter_map(|point| {
            let same = |other: &&Point| {
                other.maker == point.maker && other.h == point.h && other.tolerance == point.tolerance
            };
            free.points.iter().find(same).map(|other| (point, other))
        })
        .filter(|(point, other)| point.state.is_sound() && other.state.is_sound())
        .collect();
    let mut text = String::from(
        "| peer | step, s | ms a second | error, m | energy, J | ours | step, s | ms a second | error, m | energy, J | time, theirs = 1 |\n\
         |---|--:|--:|--:|--:|---|--:|--:|--:|--:|--:|\n",
    );
    let mut any = false;
    for (point, energy) in both.iter().filter(|(point, _)| point.is_peer) {
        any = true;
        let ours = both
            .iter()
            .filter(|(own, drift)| !own.is_peer && own.error <= point.error && drift.error <= energy.error);
        let best = ours.min_by(|a, b| a.0.cost().total_cmp(&b.0.cost()));
        let _ = write!(
            text,
            "| {} | {:.1e} | {} | {:.1e} | {:.1e} |",
            point.maker,
            point.h,
            three(point.cost()),
            point.error,
            energy.error
        );
        let _ = match best {
            Some((own, drift)) => {
                let tolerance =
                    own.tolerance.map_or(String::new(), |tolerance| format!(", tolerance {tolerance:e}"));
                writeln!(
                    text,
                    " {}{tolerance} | {:.1e} | {} | {:.1e} | {:.1e} | {:.2} |",
                    own.maker,
                    own.h,
                    three(own.cost()),
                    own.error,
                    drift.error,
                    own.cost() / point.cost()
                )
            }
            None => writeln!(text, " none | | | | | |"),
        };
    }
    any.then_some(text)
}
