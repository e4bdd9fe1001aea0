//! Both methods at a noise.

use anyhow::{Context, Result};

use super::{
    calibration::{Compared, Kind, camera},
    scene::Stage,
    shot::{Found, Shot, Told},
};
use crate::{layout::LayoutTarget, measure::px};

/// A centre farther from the true one, px, is another target's.
const NEAR: f64 = 1.0;

/// What is left of many places.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Root mean square of one coordinate, px.
    pub rms: f64,
    /// Largest of all coordinates, px.
    pub largest: f64,
}

impl Spread {
    /// Of these differences, px.
    pub fn of(differences: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let (mut squares, mut count, mut largest) = (0.0, 0, 0.0f64);
        for coordinate in differences.into_iter().flatten() {
            squares += coordinate * coordinate;
            count += 1;
            largest = largest.max(coordinate.abs());
        }
        Self { rms: (squares / f64::from(count.max(1))).sqrt(), largest }
    }
}

/// The board at a noise.
#[derive(Clone, Debug)]
pub struct Level {
    /// Standard deviation of a pixel, grey levels.
    pub noise: f64,
    /// Plain targets that were found and identified, in all views.
    pub found: usize,
    /// Those of them that were taken for another, or are nowhere near a target.
    pub wrong: usize,
    /// Coded markers whose id was read, and is right.
    pub coded: usize,
    /// Targets found that are none of the board.
    pub unmatched: usize,
    /// The compared method less eq. (7), by view.
    pub deviations: Vec<Vec<[f64; 2]>>,
    /// The same in short.
    pub deviation: Spread,
    /// What the centres are off the true ones: by eq. (7), ...
    pub eq7: Spread,
    /// ... by eq. (3) on the inner ellipses, ...
    pub eq3: Spread,
    /// ... with the correction shared by the targets of a view.
    pub pooled: Spread,
}

/// `a` - `b`.
pub fn less([a, b]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [a - x, b - y]
}

/// The views at this noise, each with a noise of its own.
///
/// # Errors
/// What [`Shot::new`] refuses.
pub fn shots(stages: &[Stage], noise: f64, told: Told) -> Result<Vec<Shot>> {
    let shot = |(seed, stage)| Shot::new(stage, noise, seed, told);
    (1..).zip(stages).map(shot).collect()
}

impl Level {
    /// Rendered views with this noise.
    ///
    /// # Errors
    /// What the detector, the matching or the calibration refuses.
    pub fn new(stages: &[Stage], noise: f64) -> Result<Self> {
        let shots = shots(stages, noise, Told::Ratio)?;
        let compared = Compared::new(&camera(stages, &shots, Kind::Inner)?)?;
        let (mut eq7, mut eq3, mut pooled) = (Vec::new(), Vec::new(), Vec::new());
        let mut deviations = Vec::new();
        for (view, (stage, shot)) in stages.iter().zip(&shots).enumerate() {
            let mut deviation = Vec::new();
            for (found, printed) in plain(stage, shot) {
                let truth = stage.centre(found.index).context("a view whose truth is known")?;
                let inner = found.target.circles.last().context("a target has circles")?.ellipse.centre;
                let radius = *printed.radii.last().context("a target has radii")?;
                let first = compared.correct(view, printed.position, inner, radius)?;
                let second = px(found.target.eq7);
                deviation.push(less(first, second));
                eq3.push(less(first, truth));
                eq7.push(less(second, truth));
                pooled.push(less(px(found.pooled), truth));
            }
            deviations.push(deviation);
        }
        Ok(Self {
            noise,
            found: eq7.len(),
            wrong: eq7.iter().filter(|[x, y]| x.hypot(*y) > NEAR).count(),
            coded: stages.iter().zip(&shots).map(|(stage, shot)| markers(stage, shot)).sum(),
            unmatched: shots.iter().map(|shot| shot.unmatched).sum(),
            deviation: Spread::of(deviations.iter().flatten().copied()),
            deviations,
            eq7: Spread::of(eq7),
            eq3: Spread::of(eq3),
            pooled: Spread::of(pooled),
        })
    }
}

/// Number of coded markers of a shot that carry the id of their place.
fn markers(stage: &Stage, shot: &Shot) -> usize {
    let right = |found: &&Found| {
        let printed = stage.layout.targets.get(found.index).and_then(|target| target.id);
        printed.is_some() && printed == found.target.code.map(|code| code.id)
    };
    shot.found.iter().filter(right).count()
}

/// The plain targets of a shot, and what is printed.
pub fn plain<'s>(stage: &'s Stage, shot: &'s Shot) -> impl Iterator<Item = (&'s Found, &'s LayoutTarget)> {
    shot.found.iter().filter_map(|found| {
        let target = stage.layout.targets.get(found.index).filter(|target| target.id.is_none())?;
        Some((found, target))
    })
}
