//! What each form of the centre costs, from no eccentricity to much.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, axes, chart, legend};
use crate::{
    accuracy::{run::Outcome, study::Study},
    risk::{Risk, risk_curves},
};

/// A form: its name, its risk by theory, and the width of its line. Eq. (7) and the exact form coincide.
type Form = (&'static str, fn(&Risk) -> f64, u32);
const FORMS: [Form; 4] = [
    ("none", |risk| risk.none, 2),
    ("eq7", |risk| risk.eq7, 7),
    ("exact", |risk| risk.exact, 2),
    ("auto", |risk| risk.auto, 2),
];
/// Highest risk shown.
const HIGHEST: f64 = 4.5;
const LAST: f64 = 10.3;

/// Lines: drawn ellipse centres; dots: frames.
pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let outcomes: Vec<_> = study.slice("risk").collect();
    let theory = risk_curves();
    let mut chart = chart(area, "RMS distance from the true centre, over that of a perfect outer ellipse")
        .build_cartesian_2d(0.0..LAST, 0.0..HIGHEST)?;
    axes(&mut chart, "eccentricity over the standard deviation of the outer ellipse's centre", "risk")?;
    let inside = |point: &(f64, f64)| point.0 <= LAST && point.1 <= HIGHEST;
    for ((method, risk, width), colour) in FORMS.into_iter().zip(COLOURS) {
        let curve = theory.iter().map(|point| (point.ecc_over_sigma, risk(point))).filter(inside);
        let colour = colour.mix(2.0 / f64::from(width));
        let line = colour.stroke_width(width);
        chart
            .draw_series(LineSeries::new(curve, line))?
            .label(method)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], line));
        let measured = outcomes.iter().filter_map(|outcome| measured(outcome, method)).filter(inside);
        chart.draw_series(measured.map(|point| Circle::new(point, 2 + width / 2, colour.filled())))?;
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)?;
    Ok(!outcomes.is_empty())
}

/// Eccentricity and RMS distance in units of the bound of the outer ellipse's centre.
fn measured(outcome: &Outcome, method: &str) -> Option<(f64, f64)> {
    let unit = outcome.figures("none")?.bound * 2f64.sqrt();
    let rms = outcome.figures(method)?.rms * 2f64.sqrt();
    Some((outcome.eccentricity() / unit, rms / unit))
}
