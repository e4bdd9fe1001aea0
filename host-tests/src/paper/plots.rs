//! The paper's figures as pictures (SVG), in the style of the accuracy study.

use std::ops::Range;

use anyhow::Result;
use plotters::prelude::*;

use super::{
    board::Board,
    printed::DEVIATION,
    report::{Report, Table},
    simulation::{NOISES, number},
};
use crate::accuracy::plots::{Area, COLOURS, Chart, FAINT, GRID, Plot, TEXT, chart, font, legend};

/// Width and height of figures 4 and 5, px.
const SIZE: (u32, u32) = (1080, 440);
/// The same of figure 8.
const BOARD_SIZE: (u32, u32) = (1400, 720);
/// Half side of the square that stands for a printed value, px.
const SQUARE: i32 = 5;
/// Decades of the axis of the errors that eq. (7) leaves, px.
const ERRORS: Range<f64> = 1e-7..1e-1;

/// All of them.
///
/// # Errors
/// None that a caller can cause.
pub fn plots(report: &Report) -> Result<Vec<Plot>> {
    let mut plots = report.tables.iter().map(sweep).collect::<Result<Vec<_>>>()?;
    plots.extend(deviations(&report.board)?);
    Ok(plots)
}

/// Figure 8: a view in each panel, a cross for each target. None where no noise gives what the paper prints.
fn deviations(board: &Board) -> Result<Option<Plot>> {
    let Some(level) = board.implied() else { return Ok(None) };
    let title = "Figure 8: deviations between the compared method and eq. (7) by view";
    let panels = |area: &Area| -> Result<()> {
        let limit = 1.1 * 1000.0 * DEVIATION;
        for ((panel, shifts), letter) in area.split_evenly((2, 4)).iter().zip(&level.deviations).zip('a'..) {
            let mut chart =
                chart(panel, &format!("({letter})")).build_cartesian_2d(-limit..limit, -limit..limit)?;
            axes(&mut chart, "u, mpx", "v, mpx", &|value| value.to_string())?;
            let bound = 1000.0 * DEVIATION;
            let frame = Rectangle::new([(-bound, -bound), (bound, bound)], FAINT.stroke_width(1));
            chart.draw_series([frame])?;
            let crosses = shifts.iter().map(|[u, v]| (1000.0 * u, 1000.0 * v));
            chart.draw_series(crosses.map(|at| Cross::new(at, 4, COLOURS[0].stroke_width(1))))?;
        }
        Ok(())
    };
    svg("figure8.svg", title, BOARD_SIZE, panels).map(Some)
}

/// Draws into a text.
///
/// # Errors
/// None that a caller can cause.
pub fn svg(
    file: &'static str,
    title: &'static str,
    size: (u32, u32),
    draw: impl FnOnce(&Area) -> Result<()>,
) -> Result<Plot> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    area.fill(&WHITE)?;
    draw(&area)?;
    area.present()?;
    drop(area);
    Ok(Plot { file, title, svg })
}

/// Figures 4 and 5: what eq. (7) leaves, and the eccentricity, over the parameter of a table.
///
/// # Errors
/// None that a caller can cause.
pub fn sweep(table: &Table) -> Result<Plot> {
    svg(table.plot, table.title, SIZE, |area| {
        let (left, right) = area.split_horizontally(SIZE.0 / 2);
        corrected(table, &left)?;
        uncorrected(table, &right)
    })
}

fn span(table: &Table) -> Range<f64> {
    let last = table.rows.last().map_or(1.0, |row| (table.parameter)(&row.0));
    0.0..last * 1.06
}

fn corrected(table: &Table, area: &Area) -> Result<()> {
    let ticks = (-7..=-1).map(|power| 10f64.powi(power)).collect::<Vec<_>>();
    let title = format!("({}a) error of the centre by eq. (7)", table.figure);
    let mut chart =
        chart(area, &title).build_cartesian_2d(span(table), ERRORS.log_scale().with_key_points(ticks))?;
    axes(&mut chart, table.axis, "px", &|value| format!("{value:.0e}"))?;
    let place = |row: &super::simulation::Row| (table.parameter)(row);
    let line = table.rows.iter().map(|(row, _)| (place(row), row.eq7));
    chart
        .draw_series(LineSeries::new(line, COLOURS[0].stroke_width(2)))?
        .label("the equations")
        .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], COLOURS[0].stroke_width(2)));
    let printed = table.rows.iter().map(|(row, _)| (place(row), number(row.printed)));
    chart
        .draw_series(
            printed.map(|at| EmptyElement::at(at) + Rectangle::new(SQUARE_CORNERS, TEXT.stroke_width(1))),
        )?
        .label("printed")
        .legend(|(x, y)| {
            EmptyElement::at((x + 10, y)) + Rectangle::new(SQUARE_CORNERS, TEXT.stroke_width(1))
        });
    for (noise, colour) in [(0, COLOURS[2]), (1, COLOURS[1])] {
        let dots = table.rows.iter().map(|(row, seen)| (place(row), seen[noise].eq7));
        chart
            .draw_series(dots.filter(|at| at.1 > 0.0).map(|at| Circle::new(at, 4, colour.filled())))?
            .label(format!("rendered, noise {}", NOISES[noise]))
            .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    }
    legend(&mut chart, SeriesLabelPosition::LowerRight)
}

fn uncorrected(table: &Table, area: &Area) -> Result<()> {
    let highest = table.rows.iter().map(|(row, _)| row.outer).fold(0.0, f64::max);
    let title = format!("({}b) error of the fitted ellipse's centre", table.figure);
    let mut chart = chart(area, &title).build_cartesian_2d(span(table), 0.0..highest * 1.1)?;
    axes(&mut chart, table.axis, "px", &|value| format!("{value:.1}"))?;
    let place = |row: &super::simulation::Row| (table.parameter)(row);
    let line = table.rows.iter().map(|(row, _)| (place(row), row.outer));
    chart
        .draw_series(LineSeries::new(line, COLOURS[0].stroke_width(2)))?
        .label("eq. (3)")
        .legend(|(x, y)| PathElement::new(vec![(x, y), (x + 20, y)], COLOURS[0].stroke_width(2)));
    let colour = COLOURS[1];
    let dots = table.rows.iter().map(|(row, seen)| (place(row), seen[1].outer));
    chart
        .draw_series(dots.filter(|at| at.1 > 0.0).map(|at| Circle::new(at, 4, colour.filled())))?
        .label(format!("rendered, noise {}", NOISES[1]))
        .legend(move |(x, y)| Circle::new((x + 10, y), 4, colour.filled()));
    legend(&mut chart, SeriesLabelPosition::UpperLeft)
}

/// Corners of a square about a place on the picture.
const SQUARE_CORNERS: [(i32, i32); 2] = [(-SQUARE, -SQUARE), (SQUARE, SQUARE)];

fn axes<X, Y>(chart: &mut Chart<X, Y>, x: &str, y: &str, format: &dyn Fn(&f64) -> String) -> Result<()>
where
    X: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(FAINT)
        .label_style(font(13))
        .x_labels(8)
        .x_label_formatter(&|value| value.to_string())
        .x_desc(x)
        .y_desc(y)
        .y_label_formatter(format)
        .draw()?;
    Ok(())
}
