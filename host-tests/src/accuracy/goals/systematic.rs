//! Goals for what noise does not explain.

use super::{Goal, largest, mean, mpx};
use crate::accuracy::{
    cell::Cell,
    method::{MAIN, REFINED},
    statistics::Figures,
    study::Study,
};

pub fn goals(study: &Study) -> Vec<Goal> {
    let parts = [bias, refined_bias, shading, gamma, distortion, undistorted];
    parts.iter().filter_map(|part| part(study)).collect()
}

/// The slice of what is systematic: `(cell, figures)` of the cells that are `wanted`.
fn systematic<'s>(
    study: &'s Study,
    method: &str,
    wanted: impl Fn(&Cell) -> bool,
) -> Vec<(&'s Cell, Figures)> {
    let outcomes = study.slice("bias").filter(|outcome| wanted(&outcome.cell));
    outcomes.filter_map(|outcome| Some((&outcome.cell, outcome.figures(method)?))).collect()
}

fn plain(cell: &Cell) -> bool {
    cell.radius >= 20.0 && cell.shading == 0.0 && cell.gamma == 1.0 && cell.k1 == 0.0
}

/// Largest part of the error that noise does not explain.
fn bias(study: &Study) -> Option<Goal> {
    let figures = systematic(study, MAIN, plain);
    let (cell, value) =
        largest(figures.iter().map(|(cell, figures)| (*cell, figures.systematic.unwrap_or(f64::NAN))))?;
    Some(Goal::new(
        "noise-free bias, R >= 20, PSF 0.5 .. 1, streaming, largest",
        "<= 0.5 mpx",
        format!("{} ({})", mpx(value), cell.label()),
        value <= 0.5e-3,
    ))
}

/// Mean error over all places within the pixel and all directions: only a confidence interval beyond the goal misses it.
fn refined_bias(study: &Study) -> Option<Goal> {
    let figures = study.pooled("bias", REFINED, plain)?;
    let measured = format!("{} +- {}", mpx(figures.drift), mpx(figures.mean_spread));
    Some(Goal::new(
        "noise-free bias, R >= 20, PSF 0.5 .. 1, refined, mean",
        "<= 0.05 mpx",
        measured,
        figures.drift <= 0.05e-3 + figures.mean_spread,
    ))
}

fn shading(study: &Study) -> Option<Goal> {
    let lit = |shading: f64| {
        let cells = study.slice("shading").filter(move |outcome| outcome.cell.shading == shading);
        mean(&cells.filter_map(|outcome| Some(outcome.figures(MAIN)?.ratio())).collect::<Vec<_>>())
    };
    let extra = lit(0.3)? / lit(0.0)? - 1.0;
    let figures = systematic(study, MAIN, |cell| cell.shading == 0.3 && cell.radius >= 20.0);
    let (_, shift) = largest(figures.iter().map(|(cell, figures)| (*cell, figures.drift)))?;
    let measured = format!("{:+.1} %, {}", 100.0 * extra, mpx(shift));
    let reached = extra <= 0.03 && shift <= 0.3e-3;
    Some(Goal::new("shading 30 %: RMS / bound more, shift", "<= +3 %, <= 0.3 mpx", measured, reached))
}

fn gamma(study: &Study) -> Option<Goal> {
    let figures = systematic(study, MAIN, |cell| cell.gamma != 1.0);
    let (cell, shift) = largest(figures.iter().map(|(cell, figures)| (*cell, figures.drift)))?;
    let measured = format!("{} ({})", mpx(shift), cell.label());
    Some(Goal::new("gamma 0.6 .. 2.2, uncorrected: shift", "<= 0.7 mpx", measured, shift <= 0.7e-3))
}

/// What a distorted lens leaves of the refined centre in every direction, px, and what the noise could feign.
fn distorted(study: &Study, method: &str, radius: f64) -> Option<(f64, f64)> {
    let figures = systematic(study, method, |cell| cell.k1 != 0.0 && cell.radius == radius);
    let figures = figures.first()?.1;
    // Both coordinates together.
    Some((2f64.sqrt() * figures.systematic?, 2f64.sqrt() * figures.feigned?))
}

fn distortion(study: &Study) -> Option<Goal> {
    let [(small, _), (large, _)] = [distorted(study, REFINED, 30.0)?, distorted(study, REFINED, 60.0)?];
    let measured = format!("{}, {}", mpx(small), mpx(large));
    let reached = small <= 0.25e-3 && large <= 5e-3;
    Some(Goal::new(
        "k1 = -0.3, f 1000, not undistorted, refined: bias at R 30, R 60",
        "<= 0.25, <= 5 mpx",
        measured,
        reached,
    ))
}

/// Nothing beyond the noise.
fn undistorted(study: &Study) -> Option<Goal> {
    let biases = [distorted(study, "undistorted", 30.0)?, distorted(study, "undistorted", 60.0)?];
    let [small, large] = biases.map(|(bias, feigned)| format!("{} (noise {})", mpx(bias), mpx(feigned)));
    let reached = biases.iter().all(|(bias, feigned)| bias <= feigned);
    Some(Goal::new(
        "k1 = -0.3, f 1000, undistorted, refined: bias at R 30, R 60",
        "0 beyond the noise",
        format!("{small}, {large}"),
        reached,
    ))
}
