//! The figures that the library is measured by, each with what is asked of it.

use concentric::Flags;

use super::{
    cell::Cell, exactness::exactness, method::MAIN, run::Outcome, statistics::Figures, study::Study,
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

/// Largest ratio to the bound in any cell of the range, and ...
pub const WORST: f64 = 1.20;
/// ... on the average of these.
const AVERAGE: f64 = 1.06;
/// Noise and goal of the pooled set at each noise, px.
const POOLED: [(f64, f64); 4] = [(0.0, 0.0010), (1.0, 0.0024), (2.0, 0.0044), (5.0, 0.0108)];

/// All goals for which the study has cells.
pub fn goals(study: &Study) -> Vec<Goal> {
    let parts = [
        found,
        average,
        worst,
        measured_ratio,
        calibration,
        coverage,
        bias,
        shading,
        gamma,
        distortion,
        clipping,
        automatic,
    ];
    let mut goals: Vec<_> = parts.iter().filter_map(|part| part(study)).collect();
    goals.extend(POOLED.iter().filter_map(|&(noise, goal)| pooled(study, noise, goal)));
    goals.extend(exact_forms());
    goals
}

fn mpx(px: f64) -> String {
    format!("{:.2} mpx", 1000.0 * px)
}

/// The cell with the largest value.
fn largest<'c>(values: impl IntoIterator<Item = (&'c Cell, f64)>) -> Option<(&'c Cell, f64)> {
    values.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b))
}

fn found(study: &Study) -> Option<Goal> {
    let range = study.range();
    let frames: usize = range.iter().map(|outcome| outcome.samples().count()).sum();
    let found = study.range_figures(MAIN).iter().map(|(_, figures)| figures.found).sum::<usize>();
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

fn average(study: &Study) -> Option<Goal> {
    let ratios: Vec<_> = study.range_figures(MAIN).iter().map(|(_, figures)| figures.ratio()).collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    (!ratios.is_empty()).then(|| {
        let figure = format!("range: RMS / bound, average of {} cells", ratios.len());
        Goal::new(figure, format!("<= {AVERAGE:.2}"), format!("{mean:.3}"), mean <= AVERAGE)
    })
}

fn worst(study: &Study) -> Option<Goal> {
    let figures = study.range_figures(MAIN);
    let (cell, ratio) = largest(figures.iter().map(|(cell, figures)| (*cell, figures.ratio())))?;
    let spread = figures.iter().find(|(other, _)| *other == cell)?.1.ratio_spread();
    let measured = format!("{ratio:.3} +- {spread:.3} ({})", cell.label());
    Some(Goal::new("range: RMS / bound, worst cell", format!("<= {WORST:.2}"), measured, ratio <= WORST))
}

/// What it costs that the ratio of the radii is not known.
fn measured_ratio(study: &Study) -> Option<Goal> {
    let square = |method| {
        let figures = study.range_figures(method);
        let ratios: Vec<_> = figures.iter().map(|(_, figures)| figures.ratio().powi(2)).collect();
        (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
    };
    let cost = (square("exact-any")? / square(MAIN)?).sqrt() - 1.0;
    let measured = format!("{:+.1} %", 100.0 * cost);
    Some(Goal::new("range: RMS with the ratio not given", "<= +1 %", measured, cost <= 0.01))
}

/// A cell is outside only if its confidence interval is.
fn calibration(study: &Study) -> Option<Goal> {
    let figures = study.range_figures(MAIN);
    let least = figures.iter().map(|(_, figures)| figures.over_sigma).min_by(f64::total_cmp)?;
    let most = figures.iter().map(|(_, figures)| figures.over_sigma).max_by(f64::total_cmp)?;
    let outside = figures.iter().filter(|(_, figures)| {
        let spread = figures.over_sigma * figures.spread / figures.rms;
        figures.over_sigma - spread > 1.1 || figures.over_sigma + spread < 0.9
    });
    let outside = outside.count();
    let measured = format!("{least:.2} .. {most:.2}, {outside} of {} cells outside", figures.len());
    Some(Goal::new("range: RMS error / reported sigma, every cell", "0.9 .. 1.1", measured, outside == 0))
}

fn coverage(study: &Study) -> Option<Goal> {
    let figures = study.range_figures(MAIN);
    let least = figures.iter().map(|(_, figures)| figures.within).min_by(f64::total_cmp)?;
    let most = figures.iter().map(|(_, figures)| figures.within).max_by(f64::total_cmp)?;
    let outside = figures.iter().filter(|(_, figures)| {
        let spread = 1.96 * (0.95 * 0.05 / figures.found as f64).sqrt();
        figures.within + spread < 0.93 || figures.within - spread > 0.97
    });
    let outside = outside.count();
    let measured = format!(
        "{:.1} .. {:.1} %, {outside} of {} cells outside",
        100.0 * least,
        100.0 * most,
        figures.len()
    );
    Some(Goal::new(
        "range: inside the reported 95 % ellipse, every cell",
        "93 .. 97 %",
        measured,
        outside == 0,
    ))
}

/// The slice of what is systematic: `(cell, figures)` of the cells that are `wanted`.
fn systematic(study: &Study, wanted: impl Fn(&Cell) -> bool) -> Vec<(&Cell, Figures)> {
    let outcomes = study.slice("bias").filter(|outcome| wanted(&outcome.cell));
    outcomes.filter_map(|outcome| Some((&outcome.cell, outcome.figures(MAIN)?))).collect()
}

/// Largest part of the error that noise does not explain.
fn bias(study: &Study) -> Option<Goal> {
    let plain =
        |cell: &Cell| cell.radius >= 20.0 && cell.shading == 0.0 && cell.gamma == 1.0 && cell.k1 == 0.0;
    let figures = systematic(study, plain);
    let (cell, value) =
        largest(figures.iter().map(|(cell, figures)| (*cell, figures.systematic.unwrap_or(f64::NAN))))?;
    let measured = format!("{} ({})", mpx(value), cell.label());
    Some(Goal::new(
        "noise-free bias, R >= 20, PSF 0.5 .. 1, largest",
        "<= 0.5 mpx",
        measured,
        value <= 0.5e-3,
    ))
}

fn shading(study: &Study) -> Option<Goal> {
    let lit = |shading: f64| {
        let cells = study.slice("shading").filter(move |outcome| outcome.cell.shading == shading);
        let ratios: Vec<_> = cells.filter_map(|outcome| Some(outcome.figures(MAIN)?.ratio())).collect();
        (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
    };
    let extra = lit(0.3)? / lit(0.0)? - 1.0;
    let figures = systematic(study, |cell| cell.shading == 0.3 && cell.radius >= 20.0);
    let (_, shift) = largest(figures.iter().map(|(cell, figures)| (*cell, figures.drift)))?;
    let measured = format!("{:+.1} %, {}", 100.0 * extra, mpx(shift));
    let reached = extra <= 0.03 && shift <= 0.3e-3;
    Some(Goal::new("shading 30 %: RMS / bound more, shift", "<= +3 %, <= 0.3 mpx", measured, reached))
}

fn gamma(study: &Study) -> Option<Goal> {
    let figures = systematic(study, |cell| cell.gamma != 1.0);
    let (cell, shift) = largest(figures.iter().map(|(cell, figures)| (*cell, figures.drift)))?;
    let measured = format!("{} ({})", mpx(shift), cell.label());
    Some(Goal::new("gamma 0.6 .. 2.2, uncorrected: shift", "<= 0.7 mpx", measured, shift <= 0.7e-3))
}

fn distortion(study: &Study) -> Option<Goal> {
    let at = |radius: f64| {
        let figures = systematic(study, |cell| cell.k1 != 0.0 && cell.radius == radius);
        figures.first().map(|(_, figures)| figures.drift)
    };
    let (small, large) = (at(30.0)?, at(60.0)?);
    let measured = format!("{}, {}", mpx(small), mpx(large));
    let reached = small <= 0.25e-3 && large <= 5e-3;
    Some(Goal::new("k1 = -0.3, not undistorted: shift at R 30, R 60", "<= 0.25, <= 5 mpx", measured, reached))
}

fn clipping(study: &Study) -> Option<Goal> {
    let cells: Vec<_> = study.slice("gain").collect();
    let frames: usize = cells.iter().map(|outcome| outcome.samples().count()).sum();
    let flagged: usize = cells.iter().map(|outcome| outcome.flagged(Flags::CLIPPED)).sum();
    (frames > 0).then(|| {
        let measured = format!("{flagged} of {frames}");
        Goal::new("overexposed by 1.5 or more: flagged as clipped", "always", measured, flagged == frames)
    })
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
