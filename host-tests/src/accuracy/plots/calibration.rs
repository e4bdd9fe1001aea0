//! Whether errors are as large as the library says.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, FAINT, axes, chart, legend, mpx, ticks};
use crate::accuracy::{
    goals::TIERS,
    study::{Study, index},
};

/// The goal for every cell: actual over reported.
const GOAL: [f64; 2] = [0.9, 1.1];

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let sides = area.split_evenly((1, 2));
    Ok(by_cell(study, &sides[0])? & coverage(study, &sides[1])?)
}

/// Actual against reported, a dot for each cell and tier.
fn by_cell(study: &Study, area: &Area) -> Result<bool> {
    let tiers = TIERS.map(|tier| (tier, study.range_figures(tier.method)));
    let all = || tiers.iter().flat_map(|(_, cells)| cells).flat_map(|(_, f)| [mpx(f.reported), mpx(f.rms)]);
    let (Some(least), Some(most)) = (all().min_by(f64::total_cmp), all().max_by(f64::total_cmp)) else {
        return Ok(false);
    };
    let axis = || {
        let (low, high) = (least * 0.8, most * 1.25);
        (low..high).log_scale().with_key_points(ticks(low, high))
    };
    let mut chart =
        chart(area, "Actual against reported error, every cell").build_cartesian_2d(axis(), axis())?;
    axes(&mut chart, "reported standard deviation, mpx", "RMS error, mpx")?;
    let ends = [least * 0.8, most * 1.25];
    // Inside the axes: what reaches beyond them is moved to their ends.
    let inside = [ends[0] / GOAL[0], ends[1] / GOAL[1]];
    let band = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(end, side)| (inside[end], inside[end] * GOAL[side]));
    chart.draw_series([Polygon::new(band.to_vec(), FAINT.mix(0.2))])?;
    chart.draw_series(LineSeries::new(ends.map(|end| (end, end)), FAINT.stroke_width(1)))?;
    for ((tier, cells), colour) in tiers.iter().zip(COLOURS) {
        chart
            .draw_series(
                cells.iter().map(|(_, f)| Circle::new((mpx(f.reported), mpx(f.rms)), 4, colour.filled())),
            )?
            .label(tier.name)
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)?;
    Ok(true)
}

/// Share of the errors inside the ellipse that should hold each share.
fn coverage(study: &Study, area: &Area) -> Result<bool> {
    let mut chart =
        chart(area, "Errors inside the reported ellipse").build_cartesian_2d(0.0..100.0, 0.0..100.0)?;
    axes(&mut chart, "ellipse that should hold, %", "holds, %")?;
    chart.draw_series(LineSeries::new([(0.0, 0.0), (100.0, 100.0)], FAINT.stroke_width(1)))?;
    let mut drawn = false;
    for (tier, colour) in TIERS.into_iter().zip(COLOURS) {
        let shares = shares(study, tier.method);
        let count = shares.len();
        let step = count.div_ceil(400).max(1);
        let holds = |i: usize| 100.0 * (i as f64 + 0.5) / count as f64;
        let curve = shares.iter().enumerate().step_by(step).map(|(i, share)| (*share, holds(i)));
        chart
            .draw_series(LineSeries::new(curve, colour.stroke_width(2)))?
            .label(tier.name)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], colour.stroke_width(2)));
        drawn |= count > 0;
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)?;
    Ok(drawn)
}

/// For each error in the range the share of errors, in per cent, that the ellipse through it should hold; ascending.
fn shares(study: &Study, method: &str) -> Vec<f64> {
    let Some(method) = index(method) else { return Vec::new() };
    // The normalised error of two coordinates is a chi square with two degrees of freedom.
    let nominal = |normalised: f64| 100.0 * (1.0 - (-normalised / 2.0).exp());
    let range = study.range();
    let samples = range.iter().flat_map(|outcome| outcome.samples());
    let mut shares: Vec<_> =
        samples.filter_map(|sample| sample.estimates[method]).map(|e| nominal(e.normalised)).collect();
    shares.sort_by(f64::total_cmp);
    shares
}
