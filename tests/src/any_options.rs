//! Random options for any text: a drawn combination may be invalid, and is then refused.
//!
//! One file for the random tests and the fuzz targets, which name it by its path.

use forcec::internals::layout::{LANES, LAYOUTS};
use forcec::{Effort, Mode, Options, Part, Precision, Target};

/// Options drawn by `draw(n)`, a number below `n`; bodies and parameters are words of the text.
pub(crate) fn any_options(text: &str, draw: &mut dyn FnMut(usize) -> usize) -> Options {
    let (mut bodies, mut parameters) = (Vec::new(), vec!["stiffness", "damping"]);
    for (before, after) in text.match_indices(':').map(|(at, _)| (&text[..at], text[at + 1..].trim_start())) {
        let name = before.rsplit(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("");
        match name.is_empty() {
            false if after.starts_with("Rigid") || after.starts_with("Particle") => bodies.push(name),
            false if ["Real", "Vec", "[", "Quat"].iter().any(|ty| after.starts_with(ty)) => {
                parameters.push(name)
            }
            _ => {}
        }
    }
    const NUMBERS: [f64; 14] =
        [0.0, 1.0, -1.0, 2.0, 0.5, 0.01, -0.3, 7.25, 1e-60, 1e300, -1e-300, 5e-324, f64::MAX, 1e9];
    let mut options = Options {
        target: [Target::C, Target::Rust][draw(2)],
        real: [Precision::F64, Precision::F32][draw(2)],
        effort: Effort::Quick,
        mode: Mode::ALL[draw(Mode::ALL.len())].1,
        fma: draw(4) == 0,
        prepare: draw(3) == 0,
        ..Options::default()
    };
    match draw(4) {
        0 => options.layout = LAYOUTS[draw(LAYOUTS.len())].layout,
        1 => options.lanes = LANES[draw(LANES.len())],
        2 => {
            let choices: Vec<Part> = Part::choices().map(|row| row.part).collect();
            options.outputs = Part::in_order((0..=draw(3)).map(|_| choices[draw(choices.len())]).collect());
        }
        _ => {}
    }
    if draw(4) == 0 && !bodies.is_empty() {
        options.fixed.push(bodies[draw(bodies.len())].to_owned());
    }
    if matches!(options.layout.row().name, "system" | "product") {
        parameters.push("step");
    }
    for _ in 0..draw(5).saturating_sub(2) {
        let name = parameters[draw(parameters.len())].to_owned();
        let value = (0..[1, 1, 1, 1, 1, 1, 3, 4][draw(8)]).map(|_| NUMBERS[draw(NUMBERS.len())]).collect();
        options.set.push((name, value));
    }
    options
}
