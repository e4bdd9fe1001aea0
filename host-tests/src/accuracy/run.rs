//! Frames through the library, on all processors. The result does not depend on how many there are.

use anyhow::{Context, Result, ensure};
use concentric::{Detector, Flags, Settings, Storage, Target};
use glam::{DMat2, DVec2};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::{
    bound::Bounds,
    cell::Cell,
    method::{METHODS, Method, Run},
};
use crate::{
    measure::px,
    render::{Scene, TargetTruth},
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
}

/// What came of one frame.
#[derive(Clone, Debug)]
pub struct Sample {
    /// By method; `None` where the target was not found.
    pub estimates: [Option<Estimate>; METHODS.len()],
    /// Flags of the target, in the first run.
    pub flags: Flags,
    /// Targets that are none, in all runs.
    pub wrong: usize,
}

/// A scene in several draws of the noise.
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
    /// By draw.
    pub samples: Vec<Sample>,
}

/// A cell and its frames.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The condition.
    pub cell: Cell,
    /// Its scenes.
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

    /// Frames in which the target carries `flag`.
    pub fn flagged(&self, flag: Flags) -> usize {
        self.samples().filter(|sample| sample.flags.contains(flag)).count()
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
            let group = group(cell, scene, memory).with_context(|| cell.name());
            progress.inc(u64::from(cell.draws));
            group
        })
        .collect::<Result<Vec<_>>>()?
        .into_iter();
    let outcome = |cell: &Cell| Outcome {
        cell: cell.clone(),
        groups: groups.by_ref().take(cell.scenes(frames) as usize).collect(),
    };
    Ok(cells.iter().map(outcome).collect())
}

fn group(cell: &Cell, index: u32, memory: &mut Memory) -> Result<Group> {
    let scene = cell.scene(index);
    scene.validate()?;
    let truth = scene.truth(0).targets.remove(0);
    ensure!(truth.complete, "the target does not lie inside the frame");
    let bounds = Bounds::new(&truth, &scene.camera, &scene.photometry, &|_| true)
        .context("too little of the target is visible")?;
    let levels = scene.levels();
    let settings = Run::ALL.into_iter().map(|run| run.settings(cell)).collect::<Result<Vec<_>>>()?;
    let samples = (0..cell.draws).map(|draw| {
        let pixels = scene.photometry.digitise(&levels.values, cell.noise_seed(index, draw));
        let seen = settings.iter().map(|&settings| detect(&pixels, levels.width, settings, memory));
        Ok(sample(&seen.collect::<Result<Vec<_>>>()?, &truth))
    });
    let outer = truth.circles[0].ellipse;
    Ok(Group {
        bounds: METHODS.map(|method| (method.bound)(&bounds)),
        eccentricity: DVec2::new(truth.x - outer.x, truth.y - outer.y).length(),
        phase: DVec2::new(truth.x - truth.x.round(), truth.y - truth.y.round()),
        axis: axis(&scene, &truth),
        samples: samples.collect::<Result<Vec<_>>>()?,
    })
}

fn axis(scene: &Scene, truth: &TargetTruth) -> DVec2 {
    let direction = scene.photometry.shading.map_or(truth.azimuth + 90.0, |light| light.direction);
    DVec2::from_angle(direction.to_radians())
}

/// The targets of a frame, through the row interface.
fn detect(pixels: &[u8], width: usize, settings: Settings, memory: &mut Memory) -> Result<Vec<Target>> {
    let height = u16::try_from(pixels.len() / width)?;
    let mut detector = Detector::new(settings, memory);
    let mut scan = detector.begin(u16::try_from(width)?, height)?;
    let mut targets = Vec::new();
    for row in pixels.chunks_exact(width) {
        targets.extend(scan.push_row(row)?);
    }
    targets.extend(scan.finish()?);
    Ok(targets)
}

/// Compares the targets of each run with the truth.
fn sample(seen: &[Vec<Target>], truth: &TargetTruth) -> Sample {
    let place = DVec2::new(truth.x, truth.y);
    let off = |target: &Target| (DVec2::from(px(target.centre)) - place).length();
    let nearest = |targets: &Vec<Target>| {
        let near = targets.iter().filter(|target| off(target) < NEAR);
        near.min_by(|a, b| off(a).total_cmp(&off(b))).cloned()
    };
    let found: Vec<_> = seen.iter().map(nearest).collect();
    let estimate = |method: Method| {
        let run = Run::ALL.iter().position(|run| *run == method.run)?;
        let target = found.get(run)?.as_ref()?;
        let error = DVec2::from(px((method.centre)(target))) - place;
        let covariance = target.covariance;
        let [xx, xy, yy] = [covariance.xx, covariance.xy, covariance.yy].map(f64::from);
        let reported = DMat2::from_cols_array(&[xx, xy, xy, yy]);
        Some(Estimate { error, normalised: error.dot(reported.inverse() * error), reported: (xx + yy) / 2.0 })
    };
    Sample {
        estimates: METHODS.map(estimate),
        flags: found.first().and_then(|found| found.as_ref()).map_or(Flags::default(), |target| target.flags),
        wrong: seen.iter().zip(&found).map(|(all, found)| all.len() - usize::from(found.is_some())).sum(),
    }
}
