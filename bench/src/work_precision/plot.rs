//! Log-log plots of time against error.

use super::measure::{Measured, Point, State};
use super::problems::Problem;
use super::tables::makers;
use crate::plot::{Axis, DRAWN, log_log, power};
use plotters::chart::SeriesLabelPosition;
use plotters::element::{Circle, Cross, DashedPathElement, PathElement};
use plotters::style::{Color, RGBColor, ShapeStyle};

const SIZE: (u32, u32) = (880, 560);

/// Makers take these colours by turns.
const COLOURS: [RGBColor; 12] = [
    RGBColor(31, 119, 180),
    RGBColor(148, 103, 189),
    RGBColor(214, 39, 40),
    RGBColor(44, 160, 44),
    RGBColor(255, 127, 14),
    RGBColor(140, 86, 75),
    RGBColor(23, 190, 207),
    RGBColor(0, 0, 0),
    RGBColor(127, 127, 127),
    RGBColor(188, 189, 34),
    RGBColor(227, 119, 194),
    RGBColor(0, 90, 90),
];

/// The points of a problem: a full dot if all steps had the requested size or were chosen by error control, a
/// ring if step control took smaller steps, a cross at the upper edge for an unusable result. Peers are
/// dashed.
pub(super) fn plot(problem: &Problem, measured: &Measured) -> String {
    let sound = |point: &&Point| point.state.is_sound() && point.error > 0.0;
    let range = |value: fn(&Point) -> f64, points: &[&Point]| {
        let (low, high) = points
            .iter()
            .map(|point| value(point))
            .fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        if low <= high { low / 2.0..high * 2.0 } else { 0.1..1.0 }
    };
    let all: Vec<&Point> = measured.points.iter().collect();
    let good: Vec<&Point> = all.iter().copied().filter(sound).collect();
    let (costs, errors) = (range(Point::cost, &all), range(|point| point.error, &good));
    let top = errors.end / 1.3;

    let axes = [
        Axis { name: "time of a simulated second, ms", range: costs, label: power },
        Axis { name: problem.error(), range: errors, label: power },
    ];
    log_log(SIZE, problem.about, axes, SeriesLabelPosition::LowerLeft, |chart| {
        for (number, (maker, points)) in makers(measured).into_iter().enumerate() {
            let colour = COLOURS[number % COLOURS.len()];
            let curve: Vec<(f64, f64)> =
                points.iter().copied().filter(sound).map(|point| (point.cost(), point.error)).collect();
            let dashed = points.iter().any(|point| point.is_peer);
            let line = if dashed {
                chart.draw_series([DashedPathElement::new(curve.clone(), 5, 3, colour.stroke_width(1))])
            } else {
                chart.draw_series([PathElement::new(curve.clone(), colour.stroke_width(2))])
            };
            line.expect(DRAWN).label(maker).legend(move |(x, y)| {
                PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(if dashed { 1 } else { 3 }))
            });
            let dot = |point: &Point| {
                let ring = point.state == State::Shortened;
                let style: ShapeStyle = if ring { colour.stroke_width(2) } else { colour.filled() };
                Circle::new((point.cost(), point.error), 4, style)
            };
            chart.draw_series(points.iter().copied().filter(sound).map(dot)).expect(DRAWN);
            let lost = points.iter().filter(|point| !point.state.is_sound());
            let lost = lost.map(|point| Cross::new((point.cost(), top), 4, colour.stroke_width(2)));
            chart.draw_series(lost).expect(DRAWN);
        }
    })
}
