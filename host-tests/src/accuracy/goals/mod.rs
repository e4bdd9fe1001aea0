//! The figures that the library is measured by, each with what is asked of it.

mod range;
mod systematic;

use concentric::Flags;

pub use range::{TIERS, Tier};

use super::{
    bound::per_coordinate,
    cell::Cell,
    exactness::exactness,
    method::{MAIN, REFINED},
    run::Outcome,
    study::{Study, index},
};

/// A figure and its goal.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// What is measured.
    pub figure: String,
    /// What is asked.
    pub goal: String,
    /// What came out.
    pub measured: String,
    /// Whether that is enough.
    pub reached: bool,
}

impl Goal {
    fn new(
        figure: impl Into<String>,
        goal: impl Into<String>,
        measured: impl Into<String>,
        reached: bool,
    ) -> Self {
        Self { figure: figure.into(), goal: goal.into(), measured: measured.into(), reached }
    }
}

/// Largest ratio to the bound where the picture is clipped under uneven light.
const CLIPPED: f64 = 1.5;
/// Largest distance from the true centre of a target that is partly hidden, over its bound.
const HIDDEN: f64 = 3.0;
/// Largest error of a target of a board, as a share of that by itself.
const SHARED: f64 = 0.52;
/// Noise and goal of the pooled set at each noise, px.
const POOLED: [(f64, f64); 4] = [(0.0, 0.0010), (1.0, 0.0024), (2.0, 0.0044), (5.0, 0.0108)];

/// All goals for which the study has cells.
pub fn goals(study: &Study) -> Vec<Goal> {
    let mut goals = [range::goals(study), systematic::goals(study)].concat();
    let parts = [clipped, clipping, automatic, hidden, shared];
    goals.extend(parts.iter().filter_map(|part| part(study)));
    goals.extend(POOLED.iter().filter_map(|&(noise, goal)| pooled(study, noise, goal)));
    goals.extend(exact_forms());
    goals
}

fn mpx(px: f64) -> String {
    format!("{:.2} mpx", 1000.0 * px)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The cell with the largest value.
fn largest<'c>(values: impl IntoIterator<Item = (&'c Cell, f64)>) -> Option<(&'c Cell, f64)> {
    values.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b))
}

fn clipped(study: &Study) -> Option<Goal> {
    let flagged = |method: &str| -> usize {
        study.slice("gain").map(|outcome| outcome.flagged(method, Flags::CLIPPED)).sum()
    };
    let found: usize =
        study.slice("gain").filter_map(|outcome| outcome.figures(MAIN)).map(|figures| figures.found).sum();
    let [rows, refined] = [MAIN, REFINED].map(flagged);
    (found > 0).then(|| {
        Goal::new(
            "overexposed by 1.5 or more: flagged as clipped, streaming, refined",
            "always",
            format!("{rows}, {refined} of {found}"),
            rows == found && refined == found,
        )
    })
}

fn clipping(study: &Study) -> Option<Goal> {
    let cells = study.slice("gain").filter(|outcome| outcome.cell.shading == 0.3);
    let ratios = cells.filter_map(|outcome| Some((&outcome.cell, outcome.figures(REFINED)?.ratio())));
    let (cell, ratio) = largest(ratios)?;
    let measured = format!("{ratio:.2} ({})", cell.label());
    let figure = "overexposed, shading 30 %, refined: RMS / bound, worst cell";
    Some(Goal::new(figure, format!("<= {CLIPPED:.1}"), measured, ratio <= CLIPPED))
}

/// What the choice of the compensation by its significance costs, from no eccentricity to ten standard deviations.
fn automatic(study: &Study) -> Option<Goal> {
    let excess = |outcome: &Outcome| {
        let [none, exact, auto] = ["none", MAIN, "auto"].map(|method| outcome.figures(method));
        Some(auto?.rms / none?.rms.min(exact?.rms))
    };
    let excesses = study.slice("risk").filter_map(|outcome| Some((&outcome.cell, excess(outcome)?)));
    let (_, excess) = largest(excesses)?;
    let figure = "eccentricity 0 .. 10 sigma: `Auto` over the better of `None` and `Exact`, worst";
    Some(Goal::new(figure, "<= 1.12", format!("{excess:.3}"), excess <= 1.12))
}

/// Targets of which a part cannot be seen, of all frames: near enough and flagged.
fn hidden(study: &Study) -> Option<Goal> {
    let share = |outcome: &Outcome, method: &str| {
        let method = index(method)?;
        let frames =
            outcome.groups.iter().flat_map(|g| g.samples.iter().map(move |s| (g, s.estimates[method])));
        let good = frames.clone().filter(|(group, estimate)| {
            // RMS distance at the bound of the arcs that can be seen.
            let least = 2f64.sqrt() * per_coordinate(group.bounds[method]);
            estimate.is_some_and(|e| e.error.length() <= HIDDEN * least && e.flags.contains(Flags::OCCLUDED))
        });
        Some(good.count() as f64 / frames.count() as f64)
    };
    let cells: Vec<_> = study.slice("hidden").collect();
    let shares = |method: &str| cells.iter().map(|o| share(o, method)).collect::<Option<Vec<_>>>();
    let [rows, refined] = [shares(MAIN)?, shares(REFINED)?];
    let list = |values: &mut dyn Iterator<Item = String>| values.collect::<Vec<_>>().join(", ");
    let per_cent = |shares: &[f64]| list(&mut shares.iter().map(|share| format!("{:.1}", 100.0 * share)));
    let radii = list(&mut cells.iter().map(|outcome| outcome.cell.radius.to_string()));
    let figure = format!(
        "{} % of the perimeter hidden, R {radii}: within {HIDDEN} x the bound of the rest and flagged, streaming; refined",
        100.0 * cells.first()?.cell.hidden
    );
    let measured = format!("{}; {} %", per_cent(&rows), per_cent(&refined));
    let reached = rows.iter().chain(&refined).all(|share| *share >= 0.99);
    Some(Goal::new(figure, ">= 99 % of all frames", measured, reached))
}

/// Centres of a board that share the correction, against each by itself.
fn shared(study: &Study) -> Option<Goal> {
    let share = |outcome: &Outcome| Some(outcome.figures("pooled")?.rms / outcome.figures("eq7")?.rms);
    let (cell, share) = largest(study.slice("board").filter_map(|o| Some((&o.cell, share(o)?))))?;
    let figure = format!("{} targets on one plane: pooled RMS / RMS of eq. (7), worst board", cell.targets);
    let measured = format!("{share:.3} ({})", cell.label());
    Some(Goal::new(figure, format!("<= {SHARED:.2}"), measured, share <= SHARED))
}

fn pooled(study: &Study, noise: f64, goal: f64) -> Option<Goal> {
    let figures = study.pooled("pooled", MAIN, |cell| cell.noise == noise)?;
    // The distance, not one coordinate, is what is compared here.
    let [rms, bound] = [figures.rms, figures.bound].map(|value| value * 2f64.sqrt());
    Some(Goal::new(
        format!("pooled set, noise {noise}: RMS distance"),
        format!("<= {goal:.4} px, all found"),
        format!("{rms:.4} px (bound {bound:.4}), {} of {} found", figures.found, figures.frames),
        rms <= goal && figures.found == figures.frames,
    ))
}

fn exact_forms() -> [Goal; 2] {
    let steep = "60 mm at 200 mm, tilt 80";
    let whole = exactness(774.0);
    let [small, large] = [exactness(100.0).device, exactness(512.0).device];
    [
        Goal::new(
            format!("exact ellipses, {steep}: error in f64 (eq. (7) leaves {:.2} px)", whole.eq7),
            "< 1e-9 px",
            format!("{:.0e} px", whole.exact),
            whole.exact < 1e-9,
        ),
        Goal::new(
            format!("exact ellipses, {steep}: error in f32, R 100, R 512"),
            "< 1e-5, < 1e-4 px",
            format!("{small:.0e}, {large:.0e} px"),
            small < 1e-5 && large < 1e-4,
        ),
    ]
}

#[cfg(test)]
mod tests;
