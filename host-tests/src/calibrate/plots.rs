//! The residuals as a picture (SVG).

use anyhow::Result;
use plotters::prelude::*;

use super::{Calibration, Residual};
use crate::{
    accuracy::plots::{Area, COLOURS, FAINT, Plot, axes, chart},
    paper::plots::svg,
};

const SIZE: (u32, u32) = (1080, 440);
/// Width over height of a chart.
const ASPECT: f64 = 1.3;
/// Length of the shift that is drawn longest, as a share of the frame's larger side.
const LONGEST: f64 = 0.06;
/// Shifts up to this share of all, by length, are drawn to scale; the longest ones reach farther.
const SCALED: f64 = 0.98;

/// Where the residuals of all views are and how they point, and how they scatter. Each view has a colour; crosses are
/// points that were left out.
///
/// # Errors
/// None that a caller can cause.
pub fn residuals(found: &Calibration) -> Result<Plot> {
    svg("residuals.svg", "Residuals of the calibration", SIZE, |area| {
        let sides = area.split_evenly((1, 2));
        field(found, &sides[0])?;
        scatter(found, &sides[1])
    })
}

fn each(found: &Calibration) -> impl Iterator<Item = (RGBColor, &Residual)> {
    let coloured = found.views.iter().zip(COLOURS.into_iter().cycle());
    coloured.flat_map(|(view, colour)| view.residuals.iter().map(move |residual| (colour, residual)))
}

/// A length of which most residuals are shorter, px; above 0.
fn scale(found: &Calibration) -> f64 {
    let kept = each(found).map(|(_, residual)| residual).filter(|residual| residual.kept);
    let mut lengths: Vec<_> = kept.map(|residual| residual.shift[0].hypot(residual.shift[1])).collect();
    lengths.sort_by(f64::total_cmp);
    let index = (lengths.len() as f64 * SCALED) as usize;
    lengths.get(index.min(lengths.len().saturating_sub(1))).copied().unwrap_or(0.0).max(1e-9)
}

fn field(found: &Calibration, area: &Area) -> Result<()> {
    let [width, height] = found.size.map(f64::from);
    let magnified = LONGEST * width.max(height) / scale(found);
    let title = format!("Measured minus projected, {} times as long", rounded(magnified));
    // Rows run down.
    let mut chart = chart(area, &title).build_cartesian_2d(0.0..width, height..0.0)?;
    axes(&mut chart, "column, px", "row, px")?;
    for (colour, residual) in each(found) {
        let [x, y] = residual.image;
        if residual.kept {
            let tip =
                (x + rounded(magnified) * residual.shift[0], y + rounded(magnified) * residual.shift[1]);
            chart.draw_series(LineSeries::new([(x, y), tip], colour.stroke_width(1)))?;
            chart.draw_series([Circle::new((x, y), 1, colour.filled())])?;
        } else {
            chart.draw_series([Cross::new((x, y), 4, colour.stroke_width(2))])?;
        }
    }
    Ok(())
}

fn scatter(found: &Calibration, area: &Area) -> Result<()> {
    let reach = 1000.0 * scale(found) * 1.3;
    let title = format!("All residuals, RMS {:.1} mpx", 1000.0 * found.rms);
    let mut chart = chart(area, &title).build_cartesian_2d(-ASPECT * reach..ASPECT * reach, reach..-reach)?;
    axes(&mut chart, "along x, mpx", "along y, mpx")?;
    for end in [[(-ASPECT * reach, 0.0), (ASPECT * reach, 0.0)], [(0.0, -reach), (0.0, reach)]] {
        chart.draw_series(LineSeries::new(end, FAINT.stroke_width(1)))?;
    }
    let kept = each(found).filter(|(_, residual)| residual.kept);
    let dots = kept.map(|(colour, residual)| {
        let [x, y] = residual.shift.map(|shift| 1000.0 * shift);
        Circle::new(
            (x.clamp(-ASPECT * reach, ASPECT * reach), y.clamp(-reach, reach)),
            2,
            colour.mix(0.6).filled(),
        )
    });
    chart.draw_series(dots)?;
    Ok(())
}

/// To one digit, downwards.
fn rounded(factor: f64) -> f64 {
    let power = 10f64.powf(factor.log10().floor());
    (factor / power).floor() * power
}
