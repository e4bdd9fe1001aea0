//! The study as pictures (SVG).

mod against_bound;
mod calibration;
mod phase;
mod risk;

use anyhow::Result;
use plotters::{
    coord::{Shift, ranged1d::ValueFormatter},
    element::ErrorBarOrientV,
    prelude::*,
};

use super::study::Study;

/// A picture.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Name of its file.
    pub file: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// Its text.
    pub svg: String,
}

/// All pictures for which the study has cells.
///
/// # Errors
/// None that a caller can cause.
pub fn plots(study: &Study) -> Result<Vec<Plot>> {
    let parts: [(_, _, Draw); 4] = [
        ("bound.svg", "Error against the bound", against_bound::draw),
        ("sigma.svg", "Calibration of the reported uncertainty", calibration::draw),
        ("phase.svg", "Bias against the place within the pixel", phase::draw),
        ("risk.svg", "Risk of the forms of compensation", risk::draw),
    ];
    let mut plots = Vec::new();
    for (file, title, draw) in parts {
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let drawn = draw(study, &area)?;
        area.present()?;
        drop(area);
        if drawn {
            plots.push(Plot { file, title, svg });
        }
    }
    Ok(plots)
}

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Chart<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;
type Bar = ErrorBar<f64, f64, ErrorBarOrientV<f64, f64>>;
/// Draws; `false` where there was nothing to draw.
type Draw = fn(&Study, &Area) -> Result<bool>;

/// Width and height, px.
const SIZE: (u32, u32) = (1080, 440);
/// Colours that are told apart by everyone (Okabe and Ito 2008, "Color universal design").
pub(crate) const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];
pub(crate) const GRID: RGBColor = RGBColor(232, 232, 232);
pub(crate) const TEXT: RGBColor = RGBColor(40, 40, 40);
pub(crate) const FAINT: RGBColor = RGBColor(130, 130, 130);

/// Text of this height.
pub(crate) fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&TEXT)
}

/// A chart with this title, without axes.
pub(crate) fn chart<'a, 'b>(area: &'a Area<'b>, title: &str) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut builder = ChartBuilder::on(area);
    builder.caption(title, font(17)).margin(14).x_label_area_size(40).y_label_area_size(52);
    builder
}

/// Axes and grid.
pub(crate) fn axes<X, Y>(chart: &mut Chart<X, Y>, x: &str, y: &str) -> Result<()>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(FAINT)
        .label_style(font(13))
        .x_labels(11)
        .x_desc(x)
        .y_desc(y)
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .draw()?;
    Ok(())
}

/// A value with its confidence interval.
fn bar(x: f64, y: f64, spread: f64, colour: RGBColor) -> Bar {
    ErrorBar::new_vertical(x, y - spread, y, y + spread, colour.filled(), 7)
}

/// What is what.
pub(crate) fn legend<'a, 'b: 'a, X, Y>(
    chart: &mut Chart<'a, 'b, X, Y>,
    position: SeriesLabelPosition,
) -> Result<()>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE)
        .border_style(GRID)
        .label_font(font(13))
        .draw()?;
    Ok(())
}

/// `1000 px`, for axes in mpx.
fn mpx(px: f64) -> f64 {
    1000.0 * px
}

/// A value without digits that say nothing.
fn plain(value: &f64) -> String {
    // Adding 0 turns -0 into 0.
    ((value * 1e3).round() / 1e3 + 0.0).to_string()
}

/// Places for labels on a logarithmic axis.
fn ticks(low: f64, high: f64) -> Vec<f64> {
    let decades = (-3..6).flat_map(|power| [1.0, 2.0, 3.0, 5.0, 7.0].map(|digit| digit * 10f64.powi(power)));
    decades.filter(|value| (low..=high).contains(value)).collect()
}
