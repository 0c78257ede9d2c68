//! The robots of the simulation benchmarks, stepped by Rapier in single and in double precision: `rapier-peer FOLDER`
//! writes `rapier.csv` there, a row a run. `bench/README.md` describes the columns.

use std::fmt::Write;

/// A body of a robot: a row of `bench/scenes/ben.csv`.
struct Link {
    parent: Option<usize>,
    mass: f64,
    inertia: [f64; 3],
    centre: [f64; 3],
    joint: [f64; 3],
}

/// What a run gave.
struct End {
    /// Seconds in steps, setting torques included.
    time: f64,
    /// Positions of the first robot's bodies, m.
    positions: Vec<[f64; 3]>,
    /// The largest change of a robot's energy, J.
    drift: f64,
}

/// How a robot is held together, and how hard Rapier tries.
#[derive(Clone, Copy)]
struct Setting {
    multibody: bool,
    iterations: usize,
}

/// Robots on a square, 3 m apart.
const SIDE: usize = 5;
const GRAVITY: f64 = 9.81;
/// A run that would take longer than this is left out, s.
const PATIENCE: f64 = 8.0;

/// The torque on a body and from it on its parent, about x where the second value is 0, else about y, N·m.
fn torque(k: usize, link: &Link, time: f64) -> (f64, usize) {
    let turn = std::f64::consts::TAU * (0.5 + 0.05 * k as f64) * time + k as f64;
    (0.3 * link.mass * GRAVITY * 0.15 * turn.sin(), k % 2)
}

mod single {
    use rapier3d::prelude as rapier;
    include!("robots.rs");
}

mod double {
    use rapier3d_f64::prelude as rapier;
    include!("robots.rs");
}

fn links() -> Vec<Link> {
    let text = include_str!("../../../scenes/ben.csv");
    let rows = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    let link = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|x| x.parse().expect("a number")).collect();
        let at = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
        let parent = (numbers[0] >= 0.0).then_some(numbers[0] as usize);
        Link { parent, mass: numbers[1], inertia: at(2), centre: at(5), joint: at(8) }
    };
    rows.map(link).collect()
}

fn main() {
    let Some(folder) = std::env::args().nth(1) else {
        eprintln!("usage: rapier-peer FOLDER");
        std::process::exit(2);
    };
    let links = links();
    let impulse =
        |iterations| (format!("impulse joints × {iterations}"), Setting { multibody: false, iterations });
    let settings = [
        impulse(4),
        impulse(32),
        ("multibody joints".to_owned(), Setting { multibody: true, iterations: 4 }),
    ];
    let mut text = String::from("engine,version,setting,scene,h,us,drift,positions\n");
    type Run = fn(&[Link], Setting, bool, f64) -> Option<End>;
    for (engine, run) in [("rapier3d", single::run as Run), ("rapier3d-f64", double::run as Run)] {
        for (name, setting) in &settings {
            for h in [1.0 / 60.0, 1.0 / 120.0, 1.0 / 240.0, 1e-3] {
                for (scene, driven) in [("ben25", true), ("ben25-free", false)] {
                    // The least of three is what a quiet machine takes; of long runs one has to do.
                    let mut ends: Vec<End> = Vec::new();
                    while ends.len() < 3 && ends.iter().all(|end| end.time < 1.0) {
                        match run(&links, *setting, driven, h) {
                            Some(end) => ends.push(end),
                            None => break,
                        }
                    }
                    let Some(last) = ends.last() else { continue };
                    let steps = (if driven { 1.0 } else { 10.0 } / h).round();
                    let least = ends.iter().map(|end| end.time).fold(f64::INFINITY, f64::min) / steps * 1e6;
                    let positions: Vec<String> =
                        last.positions.iter().flatten().map(f64::to_string).collect();
                    let (drift, positions) = if driven {
                        (String::new(), positions.join(" "))
                    } else {
                        (last.drift.to_string(), String::new())
                    };
                    let _ = writeln!(text, "{engine},0.36.1,{name},{scene},{h},{least},{drift},{positions}");
                    println!("{engine}, {name}, {scene}, h {h:.2e}: {least:.0} µs a step {drift}");
                }
            }
        }
    }
    std::fs::create_dir_all(&folder).expect("a folder to write to");
    std::fs::write(std::path::Path::new(&folder).join("rapier.csv"), text).expect("a file to write");
}
