//! The reduced grid of the command `accuracy` against the page of a run before.
//!
//! `CONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test accuracy` writes that anew.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use concentric_host::accuracy::{
    bound::per_coordinate,
    csv,
    grid::Extent,
    markdown,
    method::MAIN,
    plots::plots,
    run::{Estimate, run},
    statistics::Figures,
    study::{Study, index},
};
use indicatif::ProgressBar;

/// Shown by the README.
const SHOWN: &str = "bound.svg";

static STUDY: LazyLock<Study> = LazyLock::new(|| {
    let extent = Extent::Quick;
    let outcomes =
        run(&extent.cells(), extent.frames(), &ProgressBar::hidden()).expect("the grid can be rendered");
    Study { frames: extent.frames(), outcomes }
});

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden/accuracy").join(name)
}

fn compare(name: &str, text: &str) {
    let path = golden(name);
    if std::env::var_os("CONCENTRIC_BLESS").is_some_and(|value| value == "1") {
        std::fs::create_dir_all(golden("")).expect("a folder");
        std::fs::write(&path, text).expect("a file");
        return;
    }
    let before = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    for (before, now) in before.lines().zip(text.lines()) {
        assert_eq!(before, now, "{name}: {HOW_TO_BLESS}");
    }
    assert_eq!(before.lines().count(), text.lines().count(), "{name}: {HOW_TO_BLESS}");
}

const HOW_TO_BLESS: &str = "if that is right, write it with\nCONCENTRIC_BLESS=1 cargo test --release -p concentric-host --test accuracy";

#[test]
fn reduced_grid_is_as_before() {
    let plots = plots(&STUDY).expect("plots");
    assert_eq!(plots.len(), 4);
    let shown: Vec<_> = plots.into_iter().filter(|plot| plot.file == SHOWN).collect();
    compare("accuracy.md", &markdown::page(&STUDY, &shown));
    compare(SHOWN, &shown[0].svg);
}

/// Limits for the means over the cells of the range: RMS over bound at most this, ...
const RATIO: f64 = 1.30;
/// ... actual over reported standard deviation, ...
const SIGMA: std::ops::Range<f64> = 0.85..1.15;
/// ... and what lies inside the reported 95 % ellipse.
const INSIDE: std::ops::Range<f64> = 0.90..0.99;

/// The limits that do not hold when every error is changed; `change` has the error, its square in units of the reported
/// covariance, and the bound, px.
fn broken(change: impl Fn(&mut Estimate, f64)) -> Vec<&'static str> {
    let mut study = STUDY.clone();
    let method = index(MAIN).expect("a method");
    for group in study.outcomes.iter_mut().flat_map(|outcome| &mut outcome.groups) {
        let sigma = per_coordinate(group.bounds[method]);
        let estimates = group.samples.iter_mut().filter_map(|sample| sample.estimates[method].as_mut());
        estimates.for_each(|estimate| change(estimate, sigma));
    }
    let figures = study.range_figures(MAIN);
    let mean = |value: fn(&Figures) -> f64| {
        figures.iter().map(|(_, figures)| value(figures)).sum::<f64>() / figures.len() as f64
    };
    let held = [
        ("ratio", mean(Figures::ratio) <= RATIO),
        ("sigma", SIGMA.contains(&mean(|figures| figures.over_sigma))),
        ("inside", INSIDE.contains(&mean(|figures| figures.within))),
    ];
    held.into_iter().filter(|(_, held)| !held).map(|(name, _)| name).collect()
}

#[test]
fn means_over_the_range_keep_their_limits() {
    assert_eq!(broken(|_, _| ()), [""; 0]);
    // Teeth: a shift of the size of the bound, and covariances that are off by a factor of two.
    assert_eq!(broken(|estimate, sigma| estimate.error.x += 1.5 * sigma), ["ratio"]);
    assert_eq!(broken(|estimate, _| estimate.normalised *= 2.0), ["sigma", "inside"]);
    assert_eq!(broken(|estimate, _| estimate.normalised /= 2.0), ["sigma", "inside"]);
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
