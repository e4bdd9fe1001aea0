//! What each form of the centre costs, from no eccentricity to much.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, FAINT, GRID, font};
use crate::accuracy::{run::Outcome, study::Study};

/// Shown: the others coincide with one of these.
const SHOWN: [&str; 3] = ["none", "eq7", "exact"];

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let outcomes: Vec<_> = study.slice("risk").collect();
    let curves: Vec<_> = SHOWN.iter().map(|&method| (method, curve(&outcomes, method))).collect();
    let all = || curves.iter().flat_map(|(_, curve)| curve);
    let most = all().map(|point| point.0).fold(0.0, f64::max);
    let highest = all().map(|point| point.1).fold(2.0, f64::max).min(6.0);
    let mut chart = ChartBuilder::on(area)
        .caption("RMS distance from the true centre, over that of a perfect outer ellipse", font(17))
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(52)
        .build_cartesian_2d(0.0..most.max(1.0) * 1.02, 0.0..highest)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(FAINT)
        .label_style(font(13))
        .x_labels(11)
        .x_desc("eccentricity over the standard deviation of the outer ellipse's centre")
        .x_label_formatter(&|value| format!("{value:.0}"))
        .y_label_formatter(&|value| format!("{value:.1}"))
        .draw()?;
    for ((method, curve), colour) in curves.iter().zip(COLOURS) {
        let inside = curve.iter().filter(|point| point.1 <= highest);
        chart
            .draw_series(LineSeries::new(inside.copied(), colour.stroke_width(2)).point_size(3))?
            .label(*method)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE)
        .border_style(GRID)
        .label_font(font(13))
        .draw()?;
    Ok(!outcomes.is_empty())
}

/// Eccentricity and RMS distance in units of the outer ellipse's standard deviation.
fn curve(outcomes: &[&Outcome], method: &str) -> Vec<(f64, f64)> {
    let point = |outcome: &&Outcome| {
        let unit = outcome.figures("none")?.bound * 2f64.sqrt();
        let rms = outcome.figures(method)?.rms * 2f64.sqrt();
        Some((outcome.eccentricity() / unit, rms / unit))
    };
    let mut curve: Vec<_> = outcomes.iter().filter_map(point).collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}
