//! Frames through the library, on all processors. The result does not depend on how many there are.

use anyhow::{Context, Result, ensure};
use concentric::{Detector, Flags, Image, Settings, Storage, Target};
use glam::{DMat2, DVec2};
use indicatif::ProgressBar;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::{
    bound::Bounds,
    cell::Cell,
    efficient::Efficient,
    method::{METHODS, Method, Run},
    study::index,
};
use crate::{
    measure::px,
    render::{Levels, Scene, TargetTruth},
};

/// A found centre farther from the true one than this, px, belongs to something else.
const NEAR: f64 = 5.0;

type Memory = Box<Storage<2048, 512, 20_000>>;

/// What one method made of one frame.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Found minus true centre, px.
    pub error: DVec2,
    /// Squared error in units of the reported covariance: 2 on average if that is right.
    pub normalised: f64,
    /// Reported variance of one coordinate, px^2.
    pub reported: f64,
    /// Of the target.
    pub flags: Flags,
}

/// What came of one frame.
#[derive(Clone, Debug)]
pub struct Sample {
    /// By method; `None` where the target was not found.
    pub estimates: [Option<Estimate>; METHODS.len()],
    /// Targets that are none in this frame, in all runs; counted with the first target of a board.
    pub wrong: usize,
    /// What the noise of this frame makes of any good estimate, see [`Efficient::control`]; 0 where that is not known.
    pub control: f64,
}

/// A target of a scene in several draws of the noise.
#[derive(Clone, Debug)]
pub struct Group {
    /// Least covariances, px^2, by method.
    pub bounds: [DMat2; METHODS.len()],
    /// True centre minus that of the outer ellipse, px.
    pub eccentricity: f64,
    /// Place within the pixel, px, -0.5 to 0.5.
    pub phase: DVec2,
    /// Direction from which errors are counted: that of the light, or else of the tilt.
    pub axis: DVec2,
    /// Whether the draws are not independent: their noise cancels in the mean.
    pub dithered: bool,
    /// By draw.
    pub samples: Vec<Sample>,
}

/// A cell and its frames.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The condition.
    pub cell: Cell,
    /// The targets of its scenes.
    pub groups: Vec<Group>,
}

impl Outcome {
    /// The frames.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.groups.iter().flat_map(|group| &group.samples)
    }

    /// Mean distance of the outer ellipse's centre from the true one, px.
    pub fn eccentricity(&self) -> f64 {
        self.groups.iter().map(|group| group.eccentricity).sum::<f64>() / self.groups.len() as f64
    }

    /// Targets that are none.
    pub fn wrong(&self) -> usize {
        self.samples().map(|sample| sample.wrong).sum()
    }

    /// Frames in which the target of this method carries `flag`.
    pub fn flagged(&self, method: &str, flag: Flags) -> usize {
        let Some(method) = index(method) else { return 0 };
        self.samples()
            .filter_map(|sample| sample.estimates[method])
            .filter(|e| e.flags.contains(flag))
            .count()
    }
}

/// Shows at least `frames` frames of every cell to the library.
///
/// # Errors
/// A cell that cannot be rendered, or that the library refuses.
pub fn run(cells: &[Cell], frames: u32, progress: &ProgressBar) -> Result<Vec<Outcome>> {
    let jobs: Vec<_> =
        cells.iter().flat_map(|cell| (0..cell.scenes(frames)).map(move |scene| (cell, scene))).collect();
    progress.set_length(jobs.iter().map(|(cell, _)| u64::from(cell.draws)).sum());
    let mut groups = jobs
        .par_iter()
        .map_init(Memory::default, |memory, &(cell, scene)| {
            let groups = groups(cell, scene, memory).with_context(|| cell.name());
            progress.inc(u64::from(cell.draws));
            groups
        })
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .flatten();
    let outcome = |cell: &Cell| Outcome {
        cell: cell.clone(),
        groups: groups.by_ref().take((cell.scenes(frames) * cell.targets) as usize).collect(),
    };
    Ok(cells.iter().map(outcome).collect())
}

/// The targets of a scene, each in all draws.
fn groups(cell: &Cell, index: u32, memory: &mut Memory) -> Result<Vec<Group>> {
    let scene = cell.scene(index);
    scene.validate()?;
    let truths = scene.truth(0).targets;
    let mut groups =
        truths.iter().map(|truth| empty(&scene, truth, cell.dithered)).collect::<Result<Vec<_>>>()?;
    let levels = scene.levels();
    let efficient = efficient(cell, &scene, &truths, &levels)?;
    let runs: Vec<_> = Run::ALL.into_iter().filter(|run| run.concerns(cell)).collect();
    for draw in 0..cell.draws {
        let pixels = if cell.dithered {
            dithered(&levels.values, (draw, cell.draws), cell.noise_seed(index, 0))
        } else {
            scene.photometry.digitise(&levels.values, cell.noise_seed(index, draw))
        };
        let image = Image::new(&pixels, u16::try_from(levels.width)?, u16::try_from(levels.height)?)?;
        let mut seen = Vec::new();
        for &run in &runs {
            let settings = run.settings(cell, &scene.camera)?;
            let mut targets = detect(&pixels, image.size(), settings, memory)?;
            run.finish(&mut targets, &settings, &image)?;
            seen.push((run, targets));
        }
        let mut samples: Vec<_> = truths.iter().map(|truth| sample(&seen, truth)).collect();
        let wrong = seen.iter().map(|(_, targets)| wrong(targets, &truths)).sum();
        samples.iter_mut().take(1).for_each(|sample| sample.wrong = wrong);
        if let (Some(efficient), [sample]) = (&efficient, samples.as_mut_slice()) {
            sample.control = efficient.control(&pixels, &levels);
        }
        groups.iter_mut().zip(samples).for_each(|(group, sample)| group.samples.push(sample));
    }
    Ok(groups)
}

/// For the cells of the goals.
fn efficient(
    cell: &Cell,
    scene: &Scene,
    truths: &[TargetTruth],
    levels: &Levels,
) -> Result<Option<Efficient>> {
    let [truth] = truths else { return Ok(None) };
    if !cell.in_range() {
        return Ok(None);
    }
    let bounds = Bounds::new(truth, &scene.camera, &scene.photometry, &|_| true);
    let combination = bounds.context("too little of a target is visible")?.combination;
    Ok(Efficient::new(scene, truth, &combination, levels))
}

/// The levels rounded up or down: over `draws` the threshold of each pixel goes through as many even steps, from one of its own, so
/// that the mean is exact to a step. (Stratified dither; noise instead would take the square of that many draws.)
fn dithered(levels: &[f64], (draw, draws): (u32, u32), seed: u64) -> Vec<u8> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut threshold = || (f64::from((draw + random.next_u32() % draws) % draws) + 0.5) / f64::from(draws);
    // The cast saturates at 0 and 255.
    levels.iter().map(|level| (level + threshold()).floor() as u8).collect()
}

/// A target of a scene before it was seen.
fn empty(scene: &Scene, truth: &TargetTruth, dithered: bool) -> Result<Group> {
    ensure!(truth.complete, "a target does not lie inside the frame");
    let visible =
        |place: DVec2| !scene.occluders.iter().any(|cover| cover.hides(place, &scene.targets, &scene.camera));
    let bounds = Bounds::new(truth, &scene.camera, &scene.photometry, &visible)
        .context("too little of a target is visible")?;
    let outer = truth.circles[0].ellipse;
    Ok(Group {
        bounds: METHODS.map(|method| (method.bound)(&bounds)),
        eccentricity: DVec2::new(truth.x - outer.x, truth.y - outer.y).length(),
        phase: DVec2::new(truth.x - truth.x.round(), truth.y - truth.y.round()),
        axis: axis(scene, truth),
        dithered,
        samples: Vec::new(),
    })
}

fn axis(scene: &Scene, truth: &TargetTruth) -> DVec2 {
    let direction = scene.photometry.shading.map_or(truth.azimuth + 90.0, |light| light.direction);
    DVec2::from_angle(direction.to_radians())
}

/// The targets of a frame, through the row interface.
fn detect(pixels: &[u8], size: (u16, u16), settings: Settings, memory: &mut Memory) -> Result<Vec<Target>> {
    let (width, height) = size;
    let mut detector = Detector::new(settings, memory);
    let mut scan = detector.begin(width, height)?;
    let mut targets = Vec::new();
    for row in pixels.chunks_exact(usize::from(width)) {
        targets.extend(scan.push_row(row)?);
    }
    targets.extend(scan.finish()?);
    Ok(targets)
}

fn distance(target: &Target, truth: &TargetTruth) -> f64 {
    (DVec2::from(px(target.centre)) - DVec2::new(truth.x, truth.y)).length()
}

/// Targets that are none.
fn wrong(targets: &[Target], truths: &[TargetTruth]) -> usize {
    let right = |truth: &&TargetTruth| targets.iter().any(|target| distance(target, truth) < NEAR);
    targets.len().saturating_sub(truths.iter().filter(right).count())
}

/// Compares the targets of each run with the truth.
fn sample(seen: &[(Run, Vec<Target>)], truth: &TargetTruth) -> Sample {
    let place = DVec2::new(truth.x, truth.y);
    let estimate = |method: Method| {
        let (_, targets) = seen.iter().find(|(run, _)| *run == method.run)?;
        let near = targets.iter().filter(|target| distance(target, truth) < NEAR);
        let target = near.min_by(|a, b| distance(a, truth).total_cmp(&distance(b, truth)))?;
        let error = DVec2::from(px((method.centre)(target))) - place;
        let covariance = target.covariance;
        let [xx, xy, yy] = [covariance.xx, covariance.xy, covariance.yy].map(f64::from);
        let matrix = DMat2::from_cols_array(&[xx, xy, xy, yy]);
        let normalised = error.dot(matrix.inverse() * error);
        Some(Estimate { error, normalised, reported: (xx + yy) / 2.0, flags: target.flags })
    };
    Sample { estimates: METHODS.map(estimate), wrong: 0, control: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over the draws is the level to half a step; every draw is it to a level, and each pixel goes its own way.
    #[test]
    fn dithered_pictures_have_finer_levels_on_average() {
        let levels: Vec<f64> = (0..1000).map(|i| 40.0 + 0.137 * f64::from(i)).collect();
        let draws = 20;
        let pictures: Vec<_> = (0..draws).map(|draw| dithered(&levels, (draw, draws), 3)).collect();
        for (i, level) in levels.iter().enumerate() {
            let values = pictures.iter().map(|picture| f64::from(picture[i]));
            assert!(values.clone().all(|value| (value - level).abs() < 1.0));
            let mean = values.sum::<f64>() / f64::from(draws);
            assert!((mean - level).abs() <= 0.5 / f64::from(draws) + 1e-9, "{mean} for {level}");
        }
        let up =
            pictures[0].iter().zip(&levels).filter(|(value, level)| f64::from(**value) > **level).count();
        assert!((400..600).contains(&up), "{up}");
    }
}
