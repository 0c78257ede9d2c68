//! A picture of a scene: the bodies in their current state, lit from above, and the energy over time below.
//!
//! Input: a scene and its energies. Output: SVG. Faces are drawn from far to near, so that nearer faces cover
//! farther ones.

use crate::scenes::Scene;
use forcec_runtime::nalgebra::Rotation3;
use forcec_runtime::prelude::Vec3;
use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::drawing::IntoDrawingArea;
use plotters::series::LineSeries;
use plotters::style::{Color, RGBColor};
use std::fmt::Write;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 640.0;
const GRAPH: f64 = 200.0;
const MARGIN: f64 = 40.0;

/// Bodies take these colours by turns.
const COLOURS: [[f64; 3]; 5] =
    [[0.36, 0.55, 0.74], [0.88, 0.62, 0.35], [0.50, 0.68, 0.45], [0.75, 0.45, 0.45], [0.60, 0.54, 0.72]];
const EARTH: [f64; 3] = [0.87, 0.85, 0.80];

/// A polygon of a body.
struct Face {
    corners: Vec<Vec3>,
    colour: [f64; 3],
}

/// The scene as SVG, with its energies, a step apart, below.
pub fn picture(scene: &Scene, energies: &[f64], h: f64) -> String {
    let view = view();
    let ground = ground(scene);
    let mut faces = faces(scene);
    let middle = |face: &Face| face.corners.iter().sum::<Vec3>() / face.corners.len() as f64;
    faces.sort_by(|a, b| (view * middle(a)).y.total_cmp(&(view * middle(b)).y).reverse());

    let all = faces.iter().flat_map(|face| &face.corners).chain(&scene.look.pins);
    let (low, high) = all.fold((Vec3::repeat(f64::MAX), Vec3::repeat(f64::MIN)), |(low, high), corner| {
        let seen = view * corner;
        (low.inf(&seen), high.sup(&seen))
    });
    let size = (high - low).map(|size| size.max(1e-9));
    let scale = ((WIDTH - 2.0 * MARGIN) / size.x).min((HEIGHT - 2.0 * MARGIN) / size.z);
    let place = |corner: &Vec3| {
        let from_middle = (view * corner - (low + high) / 2.0) * scale;
        (WIDTH / 2.0 + from_middle.x, HEIGHT / 2.0 - from_middle.z)
    };

    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <clipPath id=\"frame\"><rect width=\"{WIDTH}\" height=\"{HEIGHT}\"/></clipPath>\n\
         <g clip-path=\"url(#frame)\" stroke=\"#333\" stroke-width=\"0.4\" stroke-linejoin=\"round\">\n",
        HEIGHT + GRAPH
    );
    for face in ground.iter().chain(&faces) {
        let points: Vec<String> = face
            .corners
            .iter()
            .map(|corner| {
                let (x, y) = place(corner);
                format!("{x:.1} {y:.1}")
            })
            .collect();
        let _ = writeln!(text, "<path fill=\"{}\" d=\"M{}Z\"/>", shade(face, &view), points.join("L"));
    }
    for pin in &scene.look.pins {
        let (x, y) = place(pin);
        let _ = writeln!(text, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"black\"/>");
    }
    let _ =
        writeln!(text, "</g>\n<g transform=\"translate(0 {HEIGHT})\">\n{}</g>\n</svg>", graph(energies, h));
    text
}

/// Turns the world so that x goes right, y away from the eye, and z up: seen from the front, a little from the right and
/// from above.
fn view() -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vec3::x_axis(), 0.35) * Rotation3::from_axis_angle(&Vec3::z_axis(), -0.45)
}

/// What covers the rest, unsorted: those sides of boxes that are seen, and triangles.
fn faces(scene: &Scene) -> Vec<Face> {
    let mut faces = Vec::new();
    for (k, (&body, half)) in scene.bodies.iter().zip(&scene.look.boxes).enumerate() {
        let state = scene.world.rigid(body).expect("a rigid body with a box");
        let half = Vec3::from(*half);
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let corner = |(a, b): (f64, f64)| {
                let mut corner = half;
                (corner[axis], corner[u], corner[v]) = (sign * half[axis], sign * a * half[u], b * half[v]);
                state.position + state.orientation * corner
            };
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec();
            let face = Face { corners, colour: COLOURS[k % COLOURS.len()] };
            faces.extend(Some(face).filter(is_seen));
        }
    }
    let at = |body| scene.world.position(body).expect("a particle of the scene");
    let triangles = scene.look.triangles.iter();
    faces.extend(triangles.map(|corners| Face { corners: corners.map(at).to_vec(), colour: COLOURS[0] }));
    faces
}

/// Squares of the ground, from far to near.
fn ground(scene: &Scene) -> Vec<Face> {
    let Some(ground) = scene.look.ground else { return Vec::new() };
    const CELLS: usize = 24;
    let place = |k: usize| ground.half * (2.0 * k as f64 / CELLS as f64 - 1.0);
    let corner = |x: usize, y: usize| Vec3::new(place(x), place(y), (ground.height)(place(x), place(y)));
    let squares = (0..CELLS * CELLS).map(|k| (k % CELLS, CELLS - 1 - k / CELLS)).map(|(x, y)| Face {
        corners: vec![corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)],
        colour: EARTH,
    });
    squares.filter(is_seen).collect()
}

/// Whether its outer side is turned to the eye.
fn is_seen(face: &Face) -> bool {
    (view() * normal(face)).y < 0.0
}

fn normal(face: &Face) -> Vec3 {
    let [a, b, c] = [0, 1, 2].map(|k| face.corners[k]);
    (b - a).cross(&(c - b)).normalize()
}

/// Its colour in the light, whichever side is seen.
fn shade(face: &Face, view: &Rotation3<f64>) -> String {
    let normal = view * normal(face);
    let light = Vec3::new(-0.4, -0.5, 0.77).dot(&(normal * -normal.y.signum()));
    let [r, g, b] = face.colour.map(|part| (255.0 * part * (0.72 + 0.38 * light)).clamp(0.0, 255.0) as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Energy over time.
fn graph(energies: &[f64], h: f64) -> String {
    let (low, high) = energies.iter().fold((f64::MAX, f64::MIN), |(low, high), &e| (low.min(e), high.max(e)));
    // A range of the size of rounding errors is drawn as a line.
    let room = (0.05 * (high - low)).max(1e-6 * low.abs().max(high.abs())).max(f64::MIN_POSITIVE);
    let end = (energies.len() - 1).max(1) as f64 * h;
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH as u32, GRAPH as u32)).into_drawing_area();
        let chart = ChartBuilder::on(&area)
            .margin(10)
            .margin_right(MARGIN as u32)
            .x_label_area_size(40)
            .y_label_area_size(100)
            .build_cartesian_2d(0.0..end, low - room..high + room);
        let mut chart = chart.expect("a chart within its area");
        let digits = (2.0 - (high - low + 2.0 * room).log10()).ceil().clamp(0.0, 12.0) as usize;
        let labels = |energy: &f64| format!("{energy:.digits$}");
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("time, s").y_desc("energy, J").y_labels(5).y_label_formatter(&labels);
        mesh.light_line_style(RGBColor(255, 255, 255)).draw().expect("a string to draw into");
        let points = energies.iter().enumerate().map(|(step, &energy)| (step as f64 * h, energy));
        let line = LineSeries::new(points, RGBColor(187, 68, 0).stroke_width(2));
        chart.draw_series(line).expect("a string to draw into");
        area.present().expect("a string to draw into");
    }
    text
}
