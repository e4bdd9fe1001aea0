//! Whether errors are as large as the library says.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, FAINT, axes, chart, legend, mpx, ticks};
use crate::accuracy::{
    grid::RANGE,
    method::MAIN,
    study::{Study, index},
};

/// The goal for every cell: actual over reported.
const GOAL: [f64; 2] = [0.9, 1.1];

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let sides = area.split_evenly((1, 2));
    Ok(by_cell(study, &sides[0])? & coverage(study, &sides[1])?)
}

/// Actual against reported, a dot for each cell.
fn by_cell(study: &Study, area: &Area) -> Result<bool> {
    let cells = study.range_figures(MAIN);
    let all = || cells.iter().flat_map(|(_, f)| [mpx(f.reported), mpx(f.rms)]);
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
    for (slice, colour) in RANGE.into_iter().zip(COLOURS) {
        let of_slice = cells.iter().filter(|(cell, _)| cell.slice == slice);
        chart
            .draw_series(
                of_slice.map(|(_, f)| Circle::new((mpx(f.reported), mpx(f.rms)), 4, colour.filled())),
            )?
            .label(slice)
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)?;
    Ok(true)
}

/// Share of the errors inside the ellipse that should hold each share.
fn coverage(study: &Study, area: &Area) -> Result<bool> {
    let range = study.range();
    let Some(method) = index(MAIN) else { return Ok(false) };
    let samples = range.iter().flat_map(|outcome| outcome.samples());
    // The normalised error of two coordinates is a chi square with two degrees of freedom.
    let nominal = |normalised: f64| 100.0 * (1.0 - (-normalised / 2.0).exp());
    let mut shares: Vec<_> =
        samples.filter_map(|s| s.estimates[method]).map(|e| nominal(e.normalised)).collect();
    shares.sort_by(f64::total_cmp);
    let mut chart =
        chart(area, "Errors inside the reported ellipse").build_cartesian_2d(0.0..100.0, 0.0..100.0)?;
    axes(&mut chart, "ellipse that should hold, %", "holds, %")?;
    chart.draw_series(LineSeries::new([(0.0, 0.0), (100.0, 100.0)], FAINT.stroke_width(1)))?;
    let count = shares.len();
    let step = count.div_ceil(400).max(1);
    let curve = shares
        .iter()
        .enumerate()
        .step_by(step)
        .map(|(i, share)| (*share, 100.0 * (i as f64 + 0.5) / count as f64));
    chart.draw_series(LineSeries::new(curve, COLOURS[0].stroke_width(2)))?;
    Ok(count > 0)
}
