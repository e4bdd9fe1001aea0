//! Goals over the range of conditions, for every tier.

use concentric::Flags;

use super::{Goal, largest, mean};
use crate::accuracy::{
    cell::Cell,
    method::{MAIN, QUICK, REFINED},
    statistics::Figures,
    study::Study,
};

/// A way to measure, and what is asked of it.
#[derive(Clone, Copy, Debug)]
pub struct Tier {
    /// The method that stands for it.
    pub method: &'static str,
    /// What it is called.
    pub name: &'static str,
    /// Largest RMS error over the bound on the average of the cells of the range, and ...
    pub average: f64,
    /// ... in any of these.
    pub worst: f64,
}

/// While rows stream in; and after the refinement.
pub const TIERS: [Tier; 2] = [
    Tier { method: MAIN, name: "streaming", average: 1.06, worst: 1.20 },
    Tier { method: REFINED, name: "refined", average: 1.02, worst: 1.06 },
];
/// With less effort.
const LESS: Tier = Tier { method: QUICK, name: "quick", average: 1.15, worst: 1.25 };
/// What is asked of the known camera, in units of the bound of eq. (7), ...
const KNOWN: f64 = 0.45;
/// ... from this tilt on, degrees.
const KNOWN_TILT: f64 = 20.0;

pub fn goals(study: &Study) -> Vec<Goal> {
    let of_tier = |tier: Tier| {
        [average, worst, calibration, coverage].into_iter().filter_map(move |part| part(study, tier))
    };
    let mut goals: Vec<_> = [found(study), refined(study)].into_iter().flatten().collect();
    goals.extend(TIERS.into_iter().chain([LESS]).flat_map(of_tier));
    goals.extend(measured_ratio(study));
    goals.extend(known(study));
    goals
}

fn found(study: &Study) -> Option<Goal> {
    let range = study.range();
    let frames: usize = range.iter().map(|outcome| outcome.samples().count()).sum();
    let found_by =
        |method| study.range_figures(method).iter().map(|(_, figures)| figures.found).sum::<usize>();
    let found = found_by(MAIN).min(found_by(QUICK));
    let wrong: usize = range.iter().map(|outcome| outcome.wrong()).sum();
    (frames > 0).then(|| {
        Goal::new(
            "range: targets found, and false ones",
            "all, none",
            format!("{found} of {frames}, {wrong}"),
            found == frames && wrong == 0,
        )
    })
}

fn refined(study: &Study) -> Option<Goal> {
    let found = study.range_figures(REFINED).iter().map(|(_, figures)| figures.found).sum::<usize>();
    let refined: usize = study.range().iter().map(|outcome| outcome.flagged(REFINED, Flags::REFINED)).sum();
    (found > 0).then(|| {
        Goal::new(
            "range: found targets that are refined",
            "all",
            format!("{refined} of {found}"),
            refined == found,
        )
    })
}

fn ratios(study: &Study, method: &str) -> Vec<f64> {
    study.range_figures(method).iter().map(|(_, figures)| figures.ratio()).collect()
}

fn average(study: &Study, tier: Tier) -> Option<Goal> {
    let ratios = ratios(study, tier.method);
    let mean = mean(&ratios)?;
    let figure = format!("range, {}: RMS / bound, average of {} cells", tier.name, ratios.len());
    Some(Goal::new(figure, format!("<= {:.2}", tier.average), format!("{mean:.3}"), mean <= tier.average))
}

/// A cell is beyond the limit only if its confidence interval is.
fn worst(study: &Study, tier: Tier) -> Option<Goal> {
    let figures = study.range_figures(tier.method);
    let (cell, ratio) = largest(figures.iter().map(|(cell, figures)| (*cell, figures.ratio())))?;
    let spread = figures.iter().find(|(other, _)| *other == cell)?.1.ratio_spread();
    let beyond = figures.iter().filter(|(_, f)| f.ratio() - f.ratio_spread() > tier.worst).count();
    let measured =
        format!("{ratio:.3} +- {spread:.3} ({}), {beyond} of {} cells beyond", cell.label(), figures.len());
    let figure = format!("range, {}: RMS / bound, worst cell", tier.name);
    Some(Goal::new(figure, format!("<= {:.2}", tier.worst), measured, beyond == 0))
}

/// Least and largest of a figure, and the cells in which it is `outside`.
fn span(
    figures: &[(&Cell, Figures)],
    value: fn(&Figures) -> f64,
    outside: fn(&Figures) -> bool,
) -> Option<(f64, f64, usize)> {
    let values = || figures.iter().map(|(_, figures)| value(figures));
    let outside = figures.iter().filter(|(_, figures)| outside(figures)).count();
    Some((values().min_by(f64::total_cmp)?, values().max_by(f64::total_cmp)?, outside))
}

/// A cell is outside only if its confidence interval is.
fn calibration(study: &Study, tier: Tier) -> Option<Goal> {
    let figures = study.range_figures(tier.method);
    let (least, most, outside) = span(
        &figures,
        |f| f.over_sigma.0,
        |f| {
            let (ratio, spread) = f.over_sigma;
            ratio - spread > 1.1 || ratio + spread < 0.9
        },
    )?;
    let measured = format!("{least:.2} .. {most:.2}, {outside} of {} cells outside", figures.len());
    let figure = format!("range, {}: RMS error / reported sigma, every cell", tier.name);
    Some(Goal::new(figure, "0.9 .. 1.1", measured, outside == 0))
}

fn coverage(study: &Study, tier: Tier) -> Option<Goal> {
    let figures = study.range_figures(tier.method);
    let (least, most, outside) = span(
        &figures,
        |f| 100.0 * f.within,
        |f| {
            let spread = 1.96 * (0.95 * 0.05 / f.found as f64).sqrt();
            f.within + spread < 0.93 || f.within - spread > 0.97
        },
    )?;
    let measured = format!("{least:.1} .. {most:.1} %, {outside} of {} cells outside", figures.len());
    let figure = format!("range, {}: inside the reported 95 % ellipse, every cell", tier.name);
    Some(Goal::new(figure, "93 .. 97 %", measured, outside == 0))
}

/// What it costs that the ratio of the radii is not known.
fn measured_ratio(study: &Study) -> Option<Goal> {
    let square = |method| mean(&ratios(study, method).iter().map(|ratio| ratio * ratio).collect::<Vec<_>>());
    let cost = (square("exact-any")? / square(MAIN)?).sqrt() - 1.0;
    let measured = format!("{:+.1} %", 100.0 * cost);
    Some(Goal::new("range: RMS with the ratio not given", "<= +1 %", measured, cost <= 0.01))
}

/// The known camera against what is possible without it.
fn known(study: &Study) -> Option<Goal> {
    let share = |method: &str| {
        let steep = study.range().into_iter().filter(|outcome| outcome.cell.tilt >= KNOWN_TILT);
        let share = steep.filter_map(|o| Some(o.figures(method)?.rms / o.figures(MAIN)?.bound));
        mean(&share.collect::<Vec<_>>())
    };
    let [rows, refined] = [share("known")?, share("known-refined")?];
    Some(Goal::new(
        format!("range, tilt >= {KNOWN_TILT}, known camera: RMS / bound of eq. (7), streaming, refined"),
        format!("<= {KNOWN:.2}"),
        format!("{rows:.3}, {refined:.3}"),
        rows <= KNOWN && refined <= KNOWN,
    ))
}
