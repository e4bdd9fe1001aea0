//! Bias against the place within the pixel.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, axes, bar, chart, legend, mpx};
use crate::accuracy::{
    method::MAIN,
    run::Outcome,
    study::{Study, index},
};

/// Parts of a pixel.
const BINS: usize = 12;

/// A part of a pixel: its middle, the mean error there and the half width of its 95 % confidence interval, mpx.
type Bin = (f64, f64, f64);

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let sides = area.split_evenly((1, 2));
    let panels = [("none", "Centre of the outer ellipse"), (MAIN, "Exact centre")];
    let curves = panels.map(|(method, title)| {
        let curve = |outcome: &Outcome| (format!("R {} px", outcome.cell.radius), bins(outcome, method));
        (title, study.slice("phase").map(curve).collect::<Vec<_>>())
    });
    let all = curves.iter().flat_map(|(_, curves)| curves).flat_map(|(_, bins)| bins);
    let reach = all.map(|(_, mean, spread)| mean.abs() + spread).fold(0.5, f64::max) * 1.1;
    for ((title, curves), side) in curves.iter().zip(&sides) {
        panel(side, title, curves, reach)?;
    }
    Ok(curves.iter().all(|(_, curves)| !curves.is_empty()))
}

fn panel(area: &Area, title: &str, curves: &[(String, Vec<Bin>)], reach: f64) -> Result<()> {
    let mut chart = chart(area, title).build_cartesian_2d(-0.5..0.5, -reach..reach)?;
    axes(&mut chart, "place of the centre within the pixel, px", "mean error in the same direction, mpx")?;
    for ((label, bins), colour) in curves.iter().zip(COLOURS) {
        chart.draw_series(LineSeries::new(bins.iter().map(|&(x, y, _)| (x, y)), colour.stroke_width(2)))?;
        chart
            .draw_series(bins.iter().map(|&(x, y, spread)| bar(x, y, spread, colour)))?
            .label(label)
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)?;
    Ok(())
}

/// Both coordinates go into the same bins.
fn bins(outcome: &Outcome, method: &str) -> Vec<Bin> {
    let Some(method) = index(method) else { return Vec::new() };
    let mut bins = vec![Vec::new(); BINS];
    for group in &outcome.groups {
        for estimate in group.samples.iter().filter_map(|sample| sample.estimates[method]) {
            for (phase, error) in group.phase.to_array().into_iter().zip(estimate.error.to_array()) {
                let bin = ((phase + 0.5) * BINS as f64) as usize;
                bins[bin.min(BINS - 1)].push(mpx(error));
            }
        }
    }
    let summary = |(bin, errors): (usize, &Vec<f64>)| {
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count;
        ((bin as f64 + 0.5) / BINS as f64 - 0.5, mean, 1.96 * (variance / count).sqrt())
    };
    bins.iter().enumerate().filter(|(_, errors)| errors.len() > 1).map(summary).collect()
}
