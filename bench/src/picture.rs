//! A picture of a scene: its bodies seen from the side and above, and its energy over time.

use crate::scenes::Scene;
use forcec_runtime::prelude::Vec3;
use std::fmt::Write;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 640.0;
const GRAPH: f64 = 160.0;
const MARGIN: f64 = 40.0;

/// The scene as SVG, with its energies, a step apart, below.
pub fn picture(scene: &Scene, energies: &[f64], h: f64) -> String {
    let lines = lines(scene);
    let flat: Vec<[(f64, f64); 2]> = lines.iter().map(|line| line.map(project)).collect();
    let points = flat.iter().flatten();
    let (low, high) = points.fold(([f64::MAX; 2], [f64::MIN; 2]), |(low, high), &(x, y)| {
        ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)])
    });
    let size = [high[0] - low[0], high[1] - low[1]].map(|size| size.max(1e-9));
    let scale = ((WIDTH - 2.0 * MARGIN) / size[0]).min((HEIGHT - 2.0 * MARGIN) / size[1]);
    let place = |(x, y): (f64, f64)| {
        let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
        (WIDTH / 2.0 + (x - middle[0]) * scale, HEIGHT / 2.0 - (y - middle[1]) * scale)
    };
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        HEIGHT + GRAPH
    );
    text.push_str("<path fill=\"none\" stroke=\"#245\" stroke-width=\"1\" d=\"");
    for [from, to] in flat {
        let (from, to) = (place(from), place(to));
        let _ = write!(text, "M{:.1} {:.1}L{:.1} {:.1}", from.0, from.1, to.0, to.1);
    }
    text.push_str("\"/>\n");
    text.push_str(&graph(energies, h));
    text.push_str("</svg>\n");
    text
}

/// Edges of boxes and lines between particles.
fn lines(scene: &Scene) -> Vec<[Vec3; 2]> {
    let mut lines = Vec::new();
    for (&body, half) in scene.bodies.iter().zip(&scene.look.boxes) {
        let state = scene.world.rigid(body).expect("a rigid body with a box");
        let corner = |k: usize| {
            let sign = |bit: usize| if k >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let corner = Vec3::new(sign(0) * half[0], sign(1) * half[1], sign(2) * half[2]);
            state.position + state.orientation * corner
        };
        for k in 0..8 {
            lines
                .extend([1, 2, 4].iter().filter(|&bit| k & bit == 0).map(|bit| [corner(k), corner(k | bit)]));
        }
    }
    for &[a, b, c] in &scene.look.triangles {
        lines.extend(
            [[a, b], [b, c], [c, a]]
                .map(|ends| ends.map(|body| scene.world.position(body).expect("a particle of the scene"))),
        );
    }
    lines
}

/// Seen from the front, a little from the left and from above.
fn project(p: Vec3) -> (f64, f64) {
    (p.x + 0.35 * p.y, p.z + 0.25 * p.y)
}

/// Energy over time.
fn graph(energies: &[f64], h: f64) -> String {
    let (low, high) = energies.iter().fold((f64::MAX, f64::MIN), |(low, high), &e| (low.min(e), high.max(e)));
    let range = (high - low).max(1e-12 * high.abs()).max(f64::MIN_POSITIVE);
    let steps = (energies.len() - 1).max(1) as f64;
    let x = |step: usize| MARGIN + (WIDTH - 2.0 * MARGIN) * step as f64 / steps;
    let y = |energy: f64| HEIGHT + GRAPH - MARGIN - (GRAPH - 2.0 * MARGIN) * (energy - low) / range;
    let mut text = String::from("<path fill=\"none\" stroke=\"#b40\" stroke-width=\"1.5\" d=\"");
    for (step, &energy) in energies.iter().enumerate() {
        let _ = write!(text, "{}{:.1} {:.1}", if step == 0 { "M" } else { "L" }, x(step), y(energy));
    }
    text.push_str("\"/>\n");
    let end = HEIGHT + GRAPH - 14.0;
    let _ = writeln!(
        text,
        "<text x=\"{MARGIN}\" y=\"{:.0}\">energy, {high:.4e} J at most</text>\n\
         <text x=\"{MARGIN}\" y=\"{end:.0}\">{low:.4e} J at least; 0 … {:.3} s</text>",
        HEIGHT + 20.0,
        steps * h
    );
    text
}
