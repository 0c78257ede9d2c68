//! Log-log plots of a kernel's time against its error.

use super::{FAMILIES, Point};
use crate::plot::{Axis, DRAWN, log_log, power};
use plotters::chart::SeriesLabelPosition;
use plotters::element::{Circle, Cross, Text};
use plotters::style::{Color, IntoFont, RGBColor};

const SIZE: (u32, u32) = (880, 520);

const COLOURS: [RGBColor; FAMILIES.len()] =
    [RGBColor(31, 119, 180), RGBColor(214, 39, 40), RGBColor(44, 160, 44), RGBColor(255, 127, 14)];

/// One kernel: for each mode a column of dots, the largest error at the states of each family. Crosses at the upper edge
/// are errors as large as the result.
pub fn plot(points: &[Point], kernel: &str) -> String {
    let own: Vec<&Point> = points.iter().filter(|point| point.kernel == kernel).collect();
    let errors = own.iter().flat_map(|point| point.errors).map(|error| error.normwise).filter(|x| *x > 0.0);
    let least = errors.fold(1.0_f64, f64::min);
    let times = own.iter().map(|point| point.time.median);
    let (low, high) = times.fold((f64::MAX, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let axes = [
        Axis { name: "time, ns", range: low / 1.2..high * 1.6, label: |x| format!("{x:.0}") },
        Axis { name: "largest error, of the largest entry", range: least / 1e3..2.0, label: power },
    ];
    let caption = format!("{kernel}: time of an instance against the largest error");
    log_log(SIZE, &caption, axes, SeriesLabelPosition::MiddleRight, |chart| {
        for (index, (family, colour)) in FAMILIES.iter().zip(COLOURS).enumerate() {
            let at = |point: &Point| (point.time.median, point.errors[index].normwise);
            let good = own.iter().map(|point| at(point)).filter(|(_, error)| *error > 0.0 && *error < 1.0);
            let dots = good.map(|place| Circle::new(place, 4, colour.filled()));
            chart
                .draw_series(dots)
                .expect(DRAWN)
                .label(family.name())
                .legend(move |place| Circle::new(place, 4, colour.filled()));
            let lost = own.iter().map(|point| at(point)).filter(|(_, error)| *error >= 1.0);
            chart
                .draw_series(lost.map(|(x, _)| Cross::new((x, 1.0), 4, colour.stroke_width(2))))
                .expect(DRAWN);
        }
        // Names hang from their columns, each a little lower than the one before.
        let names = own.iter().enumerate().map(|(place, point)| {
            let depth = least / 3.0 / 1.55_f64.powi(place as i32);
            Text::new(point.way.name, (point.time.median, depth), ("sans-serif", 11).into_font())
        });
        chart.draw_series(names).expect(DRAWN);
    })
}
