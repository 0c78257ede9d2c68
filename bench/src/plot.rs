//! Log-log charts of time against error, as SVG.

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext, SeriesLabelPosition};
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::combinators::{IntoLogRange, LogCoord};
use plotters::drawing::IntoDrawingArea;
use plotters::style::{BLACK, Color, WHITE};
use std::ops::Range;

/// Panic message of an `expect` on drawing into a string.
pub(crate) const DRAWN: &str = "a string to draw into";

/// A chart whose axes are both logarithmic.
pub(crate) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// One axis.
pub(crate) struct Axis<'t> {
    /// The measured quantity, with its unit.
    pub(crate) name: &'t str,
    /// Lower and upper limit.
    pub(crate) range: Range<f64>,
    /// Format of the numbers.
    pub(crate) label: fn(&f64) -> String,
}

/// A number by its power of ten.
pub(crate) fn power(x: &f64) -> String {
    format!("{x:.0e}")
}

/// A chart of the given size in pixels, with the plot and its legend.
pub(crate) fn log_log(
    size: (u32, u32),
    caption: &str,
    [x, y]: [Axis; 2],
    legend: SeriesLabelPosition,
    draw: impl FnOnce(&mut Chart<'_, '_>),
) -> String {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE).expect(DRAWN);
        let chart = ChartBuilder::on(&area)
            .margin(12)
            .caption(caption, ("sans-serif", 16))
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(x.range.log_scale(), y.range.log_scale());
        let mut chart = chart.expect("a chart within its area");
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(x.name).y_desc(y.name).max_light_lines(0);
        mesh.x_label_formatter(&x.label).y_label_formatter(&y.label).draw().expect(DRAWN);
        draw(&mut chart);
        let mut labels = chart.configure_series_labels();
        labels.position(legend).border_style(BLACK.mix(0.3));
        labels.background_style(WHITE.mix(0.85)).draw().expect(DRAWN);
        area.present().expect(DRAWN);
    }
    text
}
