//! The reduced grid of the command `accuracy` against the page of a run before.
//!
//! `CONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test accuracy` writes that anew.

mod common;

use common::golden;
use std::ops::Range;
use std::sync::LazyLock;

use concentric::Flags;
use concentric_host::accuracy::{
    bound::per_coordinate,
    cell::Cell,
    csv,
    goals::goals,
    grid::Extent,
    markdown,
    method::{MAIN, REFINED},
    plots::plots,
    run::{Estimate, run},
    statistics::Figures,
    study::{Study, index},
};
use indicatif::ProgressBar;

/// Least share of targets at the end of the range that are found, per cent.
const LEAST_FOUND: usize = 99;
/// Shown by the README.
const SHOWN: &str = "bound.svg";

static STUDY: LazyLock<Study> = LazyLock::new(|| {
    let extent = Extent::Quick;
    let outcomes =
        run(&extent.cells(), extent.frames(), &ProgressBar::hidden()).expect("the grid can be rendered");
    Study { frames: extent.frames(), outcomes }
});

/// Small, dim, blurred and noisy, all at the end of the range: nearly all are found.
#[test]
fn targets_at_the_end_of_the_range_are_found() {
    let end = Cell { psf: 1.5, contrast: 40.0, noise: 3.0, ..Cell::default() };
    let cells = [
        Cell { radius: 10.0, tilt: 0.0, ..end.clone() },
        Cell { radius: 16.0, tilt: 60.0, ..end.clone() },
        Cell { radius: 10.0, tilt: 0.0, psf: 0.4, shading: 0.3, ..end },
    ];
    assert!(cells.iter().all(Cell::in_range));
    for outcome in run(&cells, 200, &ProgressBar::hidden()).expect("cells can be rendered") {
        let main = index(MAIN).expect("a method");
        let (frames, found) =
            (outcome.samples().count(), outcome.samples().filter(|s| s.estimates[main].is_some()));
        let (found, name) = (found.count(), outcome.cell.label());
        println!("{name}: {found} of {frames} found");
        assert!(100 * found >= LEAST_FOUND * frames, "{name}: {found} of {frames}");
        assert_eq!(outcome.wrong(), 0, "{name}");
    }
}

fn compare(name: &str, text: &str) {
    golden::compare(&format!("accuracy/{name}"), text, "accuracy");
}

#[test]
fn reduced_grid_is_as_before() {
    let plots = plots(&STUDY).expect("plots");
    assert_eq!(plots.len(), 4);
    let shown: Vec<_> = plots.into_iter().filter(|plot| plot.file == SHOWN).collect();
    compare("accuracy.md", &markdown::page(&STUDY, &shown));
    compare(SHOWN, &shown[0].svg);
}

/// Limits for the means over the cells of the range.
struct Limits {
    method: &'static str,
    /// RMS error over the bound, at most.
    ratio: f64,
    /// Actual over reported standard deviation.
    sigma: Range<f64>,
    /// What lies inside the reported 95 % ellipse.
    inside: Range<f64>,
}

const STREAMING: Limits = Limits { method: MAIN, ratio: 1.06, sigma: 0.95..1.05, inside: 0.93..0.97 };
const AFTERWARDS: Limits = Limits { method: REFINED, ratio: 1.04, sigma: 0.95..1.05, inside: 0.93..0.97 };

/// The limits that do not hold when every error is changed; `change` has the error, its square in units of the reported
/// covariance, and the bound, px.
fn broken(limits: &Limits, change: impl Fn(&mut Estimate, f64)) -> Vec<&'static str> {
    let mut study = STUDY.clone();
    let method = index(limits.method).expect("a method");
    for group in study.outcomes.iter_mut().flat_map(|outcome| &mut outcome.groups) {
        let sigma = per_coordinate(group.bounds[method]);
        let estimates = group.samples.iter_mut().filter_map(|sample| sample.estimates[method].as_mut());
        estimates.for_each(|estimate| change(estimate, sigma));
    }
    let figures = study.range_figures(limits.method);
    let mean = |value: fn(&Figures) -> f64| {
        figures.iter().map(|(_, figures)| value(figures)).sum::<f64>() / figures.len() as f64
    };
    let means = [mean(Figures::ratio), mean(|figures| figures.over_sigma.0), mean(|figures| figures.within)];
    let held = [
        ("ratio", means[0] <= limits.ratio),
        ("sigma", limits.sigma.contains(&means[1])),
        ("inside", limits.inside.contains(&means[2])),
    ];
    println!("{}: {means:.3?}", limits.method);
    held.into_iter().filter(|(_, held)| !held).map(|(name, _)| name).collect()
}

#[test]
fn means_over_the_range_keep_their_limits() {
    for limits in [STREAMING, AFTERWARDS] {
        assert_eq!(broken(&limits, |_, _| ()), [""; 0], "{}", limits.method);
        // Teeth: a shift of half the bound, and covariances that are off by a third.
        assert_eq!(broken(&limits, |estimate, sigma| estimate.error.x += 0.5 * sigma), ["ratio"]);
        assert_eq!(broken(&limits, |estimate, _| estimate.normalised *= 1.33), ["sigma", "inside"]);
        assert_eq!(broken(&limits, |estimate, _| estimate.normalised /= 1.33), ["sigma", "inside"]);
    }
}

/// The refinement reaches every target and gives what it promises: less error, in every cell within the confidence interval.
#[test]
fn refinement_is_never_worse() {
    for outcome in STUDY.range() {
        let [rows, refined] = [MAIN, REFINED].map(|method| outcome.figures(method).expect("all are found"));
        let reached = outcome.flagged(REFINED, Flags::REFINED);
        assert_eq!(reached, refined.found, "{}", outcome.cell.name());
        assert_eq!(outcome.flagged(MAIN, Flags::REFINED), 0);
        assert!(refined.rms <= 1.02 * rows.rms, "{}: {refined:?} {rows:?}", outcome.cell.name());
    }
}

/// Rows of overexposed targets, evenly lit or not: no frame is far off, because one would be most of the mean.
#[test]
fn clipped_levels_cost_little() {
    let clipped: Vec<_> = STUDY.outcomes.iter().filter(|outcome| outcome.cell.slice == "gain").collect();
    assert_eq!(clipped.len(), 2);
    for outcome in clipped {
        let rows = outcome.figures(MAIN).expect("all are found");
        assert_eq!(rows.found, rows.frames, "{}", outcome.cell.name());
        assert!(rows.ratio() < 1.7, "{}: {}", outcome.cell.name(), rows.ratio());
    }
}

/// What does not depend on the draw of the noise. The goals themselves have their tests with made-up errors.
#[test]
fn goals_that_do_not_hang_on_chance_are_reached() {
    let goals = goals(&STUDY);
    let reached = |part: &str| goals.iter().find(|goal| goal.figure.contains(part)).map(|goal| goal.reached);
    let parts = [
        "known camera",
        "noise-free bias, R >= 20, PSF 0.5 .. 1, streaming",
        "shading 30 %: RMS",
        "flagged as clipped",
        "overexposed, shading",
        "on one plane",
    ];
    for part in parts {
        assert_eq!(reached(part), Some(true), "{part}");
    }
    // Where contrast is 40, noise 3 and the blur wide, some are not found.
    let all = STUDY.range_figures(MAIN);
    let sum = |count: fn(&concentric_host::accuracy::statistics::Figures) -> usize| -> usize {
        all.iter().map(|(_, figures)| count(figures)).sum()
    };
    let (found, frames) = (sum(|figures| figures.found), sum(|figures| figures.frames));
    assert!(200 * found >= 199 * frames, "{found} of {frames}");
}

#[test]
fn the_number_of_processors_changes_nothing() {
    let cells: Vec<_> = Extent::Quick.cells().into_iter().filter(|cell| cell.slice == "shading").collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let outcomes =
            pool.install(|| run(&cells, 20, &ProgressBar::hidden())).expect("the grid can be rendered");
        csv::text(&Study { frames: 20, outcomes }).expect("lines")
    };
    assert_eq!(with(1), with(3));
}
