//! Error against the bound: over the size of the target, and for every cell of the range.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, FAINT, SIZE, TEXT, axes, bar, chart, legend, mpx, ticks};
use crate::accuracy::{
    goals::TIERS,
    method::{MAIN, REFINED},
    statistics::Figures,
    study::Study,
};

/// Shift of a dot for each tilt, relative.
const ASIDE: f64 = 0.012;
/// Radius of the ring that stands for a refined target, px.
const HOLLOW: u32 = 6;

pub fn draw(study: &Study, area: &Area) -> Result<bool> {
    let (left, right) = area.split_horizontally(SIZE.0 / 2);
    Ok(by_size(study, &left)? & by_cell(study, &right)?)
}

/// Lines: the bound; dots: what is measured while rows stream in; rings: after the refinement.
fn by_size(study: &Study, area: &Area) -> Result<bool> {
    let cells: Vec<_> =
        study.slice("size").filter_map(|outcome| Some((&outcome.cell, outcome.figures(MAIN)?))).collect();
    let shown: Vec<_> = cells.iter().filter(|(cell, _)| cell.in_range()).collect();
    let refined: Vec<_> = study
        .slice("size")
        .filter(|outcome| outcome.cell.in_range())
        .filter_map(|outcome| Some((&outcome.cell, outcome.figures(REFINED)?)))
        .collect();
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
        let after = refined.iter().filter(|(cell, _)| cell.tilt == tilt);
        chart.draw_series(after.map(|(c, f)| Circle::new((c.radius * aside, mpx(f.rms)), HOLLOW, colour)))?;
    }
    chart
        .draw_series([Circle::new((x.end, y.end), 0, TEXT)])?
        .label("refined")
        .legend(|(x, y)| Circle::new((x + 10, y), HOLLOW, TEXT));
    chart
        .draw_series(LineSeries::new(None, FAINT.stroke_width(2)))?
        .label("bound")
        .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], FAINT.stroke_width(2)));
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(true)
}

/// Ratio to the bound of every cell of the range.
fn by_cell(study: &Study, area: &Area) -> Result<bool> {
    let tiers = TIERS.map(|tier| (tier, study.range_figures(tier.method)));
    let all = || tiers.iter().flat_map(|(_, cells)| cells.iter().map(|(_, figures)| figures));
    let bounds = || all().map(|f| mpx(f.bound));
    let top = |f: &Figures| f.ratio() + f.ratio_spread();
    let (Some(least), Some(most)) = (bounds().min_by(f64::total_cmp), bounds().max_by(f64::total_cmp)) else {
        return Ok(false);
    };
    let highest = all().map(top).fold(1.3, f64::max);
    let x = least * 0.8..most * 1.25;
    let mut chart = chart(area, "RMS error over the bound, every cell of the range").build_cartesian_2d(
        x.clone().log_scale().with_key_points(ticks(x.start, x.end)),
        0.8..highest + 0.05,
    )?;
    axes(&mut chart, "bound, mpx", "RMS error / bound")?;
    chart.draw_series(LineSeries::new([(x.start, 1.0), (x.end, 1.0)], FAINT.stroke_width(2)))?;
    for (((tier, cells), colour), aside) in
        tiers.iter().zip(COLOURS).zip([1.0 - ASIDE / 2.0, 1.0 + ASIDE / 2.0])
    {
        let limit = [(x.start, tier.worst), (x.end, tier.worst)];
        chart.draw_series(LineSeries::new(limit, colour.stroke_width(1)))?;
        chart
            .draw_series(
                cells.iter().map(|(_, f)| bar(mpx(f.bound) * aside, f.ratio(), f.ratio_spread(), colour)),
            )?
            .label(format!("{}, limit {:.2}", tier.name, tier.worst))
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(true)
}
