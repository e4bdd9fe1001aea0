//! Error against the bound: over the size of the target, and for every cell of the range.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, FAINT, SIZE, axes, bar, chart, legend, mpx, ticks};
use crate::accuracy::{goals::WORST, grid::RANGE, method::MAIN, statistics::Figures, study::Study};

/// Shift of a dot for each tilt, relative.
const ASIDE: f64 = 0.012;

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let (left, right) = area.split_horizontally(SIZE.0 / 2);
    Ok(by_size(study, &left)? & by_cell(study, &right)?)
}

/// Lines: the bound; dots: what is measured.
fn by_size(study: &Study, area: &Area) -> Result<bool> {
    let cells: Vec<_> =
        study.slice("size").filter_map(|outcome| Some((&outcome.cell, outcome.figures(MAIN)?))).collect();
    let shown: Vec<_> = cells.iter().filter(|(cell, _)| cell.in_range()).collect();
    let sizes = || shown.iter().map(|(cell, _)| cell.radius);
    let errors = || shown.iter().flat_map(|(_, f)| [mpx(f.bound), mpx(f.rms + f.spread)]);
    let (Some(least), Some(most)) = (sizes().min_by(f64::total_cmp), sizes().max_by(f64::total_cmp)) else {
        return Ok(false);
    };
    let [low, high] = [errors().fold(f64::MAX, f64::min) * 0.8, errors().fold(0.0, f64::max) * 1.25];
    let (x, y) = (least * 0.85..most * 1.18, low..high);
    let mut chart = chart(area, "RMS error of the exact centre, one coordinate").build_cartesian_2d(
        x.clone().log_scale().with_key_points(ticks(x.start, x.end)),
        y.clone().log_scale().with_key_points(ticks(y.start, y.end)),
    )?;
    axes(&mut chart, "outer semi-major axis, px", "mpx")?;
    let mut tilts: Vec<_> = shown.iter().map(|(cell, _)| cell.tilt).collect();
    tilts.sort_by(f64::total_cmp);
    tilts.dedup();
    let middle = (tilts.len() as f64 - 1.0) / 2.0;
    for ((place, tilt), colour) in tilts.into_iter().enumerate().zip(COLOURS) {
        // Side by side, where they would hide each other.
        let aside = 1.0 + ASIDE * (place as f64 - middle);
        let row: Vec<_> = shown.iter().filter(|(cell, _)| cell.tilt == tilt).collect();
        chart.draw_series(LineSeries::new(
            row.iter().map(|(c, f)| (c.radius, mpx(f.bound))),
            colour.stroke_width(2),
        ))?;
        chart
            .draw_series(row.iter().map(|(c, f)| bar(c.radius * aside, mpx(f.rms), mpx(f.spread), colour)))?
            .label(format!("tilt {tilt} deg"))
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    chart
        .draw_series(LineSeries::new(None, FAINT.stroke_width(2)))?
        .label("bound")
        .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], FAINT.stroke_width(2)));
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(true)
}

/// Ratio to the bound of every cell of the range.
fn by_cell(study: &Study, area: &Area) -> Result<bool> {
    let cells = study.range_figures(MAIN);
    let bounds = || cells.iter().map(|(_, f)| mpx(f.bound));
    let top = |f: &Figures| f.ratio() + f.ratio_spread();
    let (Some(least), Some(most)) = (bounds().min_by(f64::total_cmp), bounds().max_by(f64::total_cmp)) else {
        return Ok(false);
    };
    let highest = cells.iter().map(|(_, f)| top(f)).fold(1.3, f64::max);
    let x = least * 0.8..most * 1.25;
    let mut chart = chart(area, "RMS error over the bound, every cell of the range").build_cartesian_2d(
        x.clone().log_scale().with_key_points(ticks(x.start, x.end)),
        0.8..highest + 0.05,
    )?;
    axes(&mut chart, "bound, mpx", "RMS error / bound")?;
    for (level, width) in [(1.0, 2), (WORST, 1)] {
        chart.draw_series(LineSeries::new([(x.start, level), (x.end, level)], FAINT.stroke_width(width)))?;
    }
    for (slice, colour) in RANGE.into_iter().zip(COLOURS) {
        let of_slice = cells.iter().filter(|(cell, _)| cell.slice == slice);
        chart
            .draw_series(of_slice.map(|(_, f)| bar(mpx(f.bound), f.ratio(), f.ratio_spread(), colour)))?
            .label(slice)
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(true)
}
