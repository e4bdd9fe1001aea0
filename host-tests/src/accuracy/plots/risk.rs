//! What each form of the centre costs, from no eccentricity to much.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, axes, chart, legend};
use crate::accuracy::{run::Outcome, study::Study};

/// Shown, and with what width: eq. (7) and the exact form coincide. The others coincide with one of these.
const SHOWN: [(&str, u32); 3] = [("none", 2), ("eq7", 7), ("exact", 2)];
/// Highest risk shown.
const HIGHEST: f64 = 6.5;

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let outcomes: Vec<_> = study.slice("risk").collect();
    let curves: Vec<_> =
        SHOWN.iter().map(|&(method, width)| (method, width, curve(&outcomes, method))).collect();
    let all = || curves.iter().flat_map(|(_, _, curve)| curve);
    let most = all().map(|point| point.0).fold(0.0, f64::max);
    let highest = all().map(|point| point.1).fold(2.0, f64::max).min(HIGHEST);
    let mut chart = chart(area, "RMS distance from the true centre, over that of a perfect outer ellipse")
        .build_cartesian_2d(0.0..most.max(1.0) * 1.02, 0.0..highest)?;
    axes(&mut chart, "eccentricity over the standard deviation of the outer ellipse's centre", "risk")?;
    for ((method, width, curve), colour) in curves.iter().zip(COLOURS) {
        let inside = curve.iter().filter(|point| point.1 <= highest);
        let line = colour.mix(2.0 / f64::from(*width)).stroke_width(*width);
        chart
            .draw_series(LineSeries::new(inside.copied(), line))?
            .label(*method)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], line));
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)?;
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
