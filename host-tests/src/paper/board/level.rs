//! Both methods at a noise.

use anyhow::{Context, Result};

use super::{
    calibration::{Compared, Kind, camera},
    scene::{RADII, Stage},
    shot::{Found, Shot, Told},
};
use crate::measure::px;

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
    /// Coded markers likewise.
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
    /// # Errors
    /// What the detector, the matching or the calibration refuses.
    pub fn new(stages: &[Stage], noise: f64) -> Result<Self> {
        let shots = shots(stages, noise, Told::Ratio)?;
        let compared = Compared::new(&camera(stages, &shots, Kind::Inner)?)?;
        let (mut eq7, mut eq3, mut pooled) = (Vec::new(), Vec::new(), Vec::new());
        let mut deviations = Vec::new();
        for (view, (stage, shot)) in stages.iter().zip(&shots).enumerate() {
            let mut deviation = Vec::new();
            for (found, object, truth) in plain(stage, shot) {
                let inner = found.target.circles.last().context("a target has circles")?.ellipse.centre;
                let first = compared.correct(view, object, inner, RADII[1])?;
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
            coded: shots.iter().map(|shot| shot.found.len()).sum::<usize>() - eq7.len(),
            unmatched: shots.iter().map(|shot| shot.unmatched).sum(),
            deviation: Spread::of(deviations.iter().flatten().copied()),
            deviations,
            eq7: Spread::of(eq7),
            eq3: Spread::of(eq3),
            pooled: Spread::of(pooled),
        })
    }
}

/// The plain targets of a shot, with their places on the board, mm, and their true centres, px.
pub fn plain<'s>(stage: &'s Stage, shot: &'s Shot) -> impl Iterator<Item = (&'s Found, [f64; 3], [f64; 2])> {
    shot.found.iter().filter_map(|found| {
        let target = stage.layout.targets.get(found.index).filter(|target| target.id.is_none())?;
        Some((found, target.position, *stage.truth.get(found.index)?))
    })
}
