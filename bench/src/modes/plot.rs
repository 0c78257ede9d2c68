//! Log-log plots of a kernel's time against its error.

use super::{FAMILIES, Point};
use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::coord::combinators::IntoLogRange;
use plotters::drawing::IntoDrawingArea;
use plotters::element::{Circle, Cross, Text};
use plotters::style::{BLACK, Color, IntoFont, RGBColor, WHITE};

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
    let mut text = String::new();
    {
        let drawn = "a string to draw into";
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        area.fill(&WHITE).expect(drawn);
        let chart = ChartBuilder::on(&area)
            .margin(12)
            .caption(format!("{kernel}: time of an instance against the largest error"), ("sans-serif", 16))
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d((low / 1.2..high * 1.6).log_scale(), (least / 1e3..2.0).log_scale());
        let mut chart = chart.expect("a chart within its area");
        let (ns, error) = (|x: &f64| format!("{x:.0}"), |x: &f64| format!("{x:.0e}"));
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("time, ns").y_desc("largest error, of the largest entry").max_light_lines(0);
        mesh.x_label_formatter(&ns).y_label_formatter(&error).draw().expect(drawn);
        for (family, colour) in FAMILIES.iter().zip(COLOURS) {
            let at = |point: &Point| {
                let index = FAMILIES.iter().position(|other| other == family).unwrap_or(0);
                (point.time.median, point.errors[index].normwise)
            };
            let good = own.iter().map(|point| at(point)).filter(|(_, error)| *error > 0.0 && *error < 1.0);
            let dots = good.map(|place| Circle::new(place, 4, colour.filled()));
            chart
                .draw_series(dots)
                .expect(drawn)
                .label(family.name())
                .legend(move |place| Circle::new(place, 4, colour.filled()));
            let lost = own.iter().map(|point| at(point)).filter(|(_, error)| *error >= 1.0);
            chart
                .draw_series(lost.map(|(x, _)| Cross::new((x, 1.0), 4, colour.stroke_width(2))))
                .expect(drawn);
        }
        // Names hang from their columns, each a little lower than the one before.
        let names = own.iter().enumerate().map(|(place, point)| {
            let depth = least / 3.0 / 1.55_f64.powi(place as i32);
            Text::new(point.way.name, (point.time.median, depth), ("sans-serif", 11).into_font())
        });
        chart.draw_series(names).expect(drawn);
        let mut legend = chart.configure_series_labels();
        legend.border_style(BLACK.mix(0.3)).background_style(WHITE.mix(0.85)).draw().expect(drawn);
        area.present().expect(drawn);
    }
    text
}
