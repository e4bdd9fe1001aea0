//! Error against the bound: over the size of the target, and for every cell of the range.

use anyhow::Result;
use plotters::prelude::*;

use super::{Area, COLOURS, FAINT, GRID, SIZE, font, mpx, plain, ticks};
use crate::accuracy::{grid::RANGE, method::MAIN, statistics::Figures, study::Study};

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
    let mut chart = ChartBuilder::on(area)
        .caption("RMS error of the exact centre, one coordinate", font(17))
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(52)
        .build_cartesian_2d(
            x.clone().log_scale().with_key_points(ticks(x.start, x.end)),
            y.clone().log_scale().with_key_points(ticks(y.start, y.end)),
        )?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(FAINT)
        .label_style(font(13))
        .x_desc("outer semi-major axis, px")
        .y_desc("mpx")
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .draw()?;
    let mut tilts: Vec<_> = shown.iter().map(|(cell, _)| cell.tilt).collect();
    tilts.sort_by(f64::total_cmp);
    tilts.dedup();
    for (tilt, colour) in tilts.into_iter().zip(COLOURS) {
        let row: Vec<_> = shown.iter().filter(|(cell, _)| cell.tilt == tilt).collect();
        chart.draw_series(LineSeries::new(
            row.iter().map(|(c, f)| (c.radius, mpx(f.bound))),
            colour.stroke_width(2),
        ))?;
        chart
            .draw_series(row.iter().map(|(c, f)| bar(c.radius, mpx(f.rms), mpx(f.spread), colour)))?
            .label(format!("tilt {tilt} deg"))
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    chart
        .draw_series(LineSeries::new(None, FAINT.stroke_width(2)))?
        .label("bound")
        .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], FAINT.stroke_width(2)));
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE)
        .border_style(GRID)
        .label_font(font(13))
        .draw()?;
    Ok(true)
}

/// A value with its confidence interval.
fn bar(
    x: f64,
    y: f64,
    spread: f64,
    colour: RGBColor,
) -> ErrorBar<f64, f64, plotters::element::ErrorBarOrientV<f64, f64>> {
    ErrorBar::new_vertical(x, y - spread, y, y + spread, colour.filled(), 7)
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
    let mut chart = ChartBuilder::on(area)
        .caption("RMS error over the bound, every cell of the range", font(17))
        .margin(14)
        .x_label_area_size(40)
        .y_label_area_size(52)
        .build_cartesian_2d(
            x.clone().log_scale().with_key_points(ticks(x.start, x.end)),
            0.8..highest + 0.05,
        )?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(FAINT)
        .label_style(font(13))
        .y_labels(8)
        .x_desc("bound, mpx")
        .y_desc("RMS error / bound")
        .x_label_formatter(&plain)
        .y_label_formatter(&plain)
        .draw()?;
    chart.draw_series(LineSeries::new([(x.start, 1.0), (x.end, 1.0)], FAINT.stroke_width(2)))?;
    for (slice, colour) in RANGE.into_iter().zip(COLOURS) {
        let of_slice = cells.iter().filter(|(cell, _)| cell.slice == slice);
        chart
            .draw_series(of_slice.map(|(_, f)| bar(mpx(f.bound), f.ratio(), f.ratio_spread(), colour)))?
            .label(slice)
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE)
        .border_style(GRID)
        .label_font(font(13))
        .draw()?;
    Ok(true)
}
