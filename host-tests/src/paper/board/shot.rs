//! A picture of the board to targets with their places on it.

use anyhow::{Context, Result};
use concentric::{
    Camera, Compensation, Detector, Image, Position, Settings, Storage, Target, TargetSpec, code,
    coplanar::pool,
};
use nalgebra::Vector2;

use super::scene::Stage;
use crate::{layout::Layout, matching::homography, measure::px, paper::simulation::RATIO};

type Memory = Box<Storage<2048, 512, 20_000>>;

/// A target of the board.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its place in the layout.
    pub index: usize,
    /// As the library found it.
    pub target: Target,
    /// Its centre when all targets of the picture share the correction.
    pub pooled: Position,
}

/// What was found on a picture.
#[derive(Clone, Debug)]
pub struct Shot {
    /// By the layout's order.
    pub found: Vec<Found>,
    /// Targets that have no place on the board.
    pub unmatched: usize,
}

/// What the library is told beside the code.
#[derive(Clone, Copy, Debug)]
pub enum Told {
    /// Nothing: the ratio of the radii is measured.
    Nothing,
    /// The ratio of the radii.
    Ratio,
    /// The ratio and the camera.
    Camera(Camera),
}

impl Told {
    fn settings(self, layout: &Layout) -> Result<Settings> {
        let spec = match self {
            Self::Nothing => TargetSpec::any(),
            Self::Ratio | Self::Camera(_) => TargetSpec::ring(RATIO as f32)?,
        };
        let mut settings = Settings::new(spec);
        if let Some(code) = layout.settings_code()? {
            settings = settings.code(code);
        }
        if let Self::Camera(camera) = self {
            settings = settings.camera(camera).compensation(Compensation::Known);
        }
        Ok(settings)
    }
}

impl Shot {
    /// A picture of `stage`.
    ///
    /// # Errors
    /// A picture on which too few coded markers are read.
    pub fn new(stage: &Stage, noise: f64, seed: u64, told: Told) -> Result<Self> {
        let pixels = stage.picture(noise, seed);
        let (width, height) = (u16::try_from(stage.levels.width)?, u16::try_from(stage.levels.height)?);
        let settings = told.settings(&stage.layout)?;
        let image = Image::new(&pixels, width, height)?;
        let mut memory = Memory::default();
        let mut detector = Detector::new(settings, &mut memory);
        let mut targets: Vec<_> = detector.detect(&image)?.collect();
        targets.iter_mut().for_each(|target| _ = code::read(&image, &settings, target));
        let mut pooled = targets.clone();
        pool(&mut pooled, settings.camera.as_ref())?;
        let places = places(&stage.layout, &targets)?;
        let unmatched = places.iter().filter(|place| place.is_none()).count();
        let all = targets.into_iter().zip(pooled).zip(places);
        let found = all.filter_map(|((target, pooled), index)| {
            Some(Found { index: index?, target, pooled: pooled.centre })
        });
        let mut found: Vec<_> = found.collect();
        found.sort_by_key(|found| found.index);
        Ok(Self { found, unmatched })
    }
}

/// The place of each target in the layout: from the coded markers to a homography, to one-to-one matches, to a better one.
fn places(layout: &Layout, targets: &[Target]) -> Result<Vec<Option<usize>>> {
    let image: Vec<_> = targets.iter().map(|target| Vector2::from(px(target.centre))).collect();
    let object: Vec<_> =
        layout.targets.iter().map(|target| Vector2::new(target.position[0], target.position[1])).collect();
    let coded = |target: &Target| {
        let id = target.code?.id;
        layout.targets.iter().position(|printed| printed.id == Some(id))
    };
    let mut places: Vec<_> = targets.iter().map(coded).collect();
    for _ in 0..2 {
        let known = places.iter().zip(&image).filter_map(|(place, image)| Some((object[(*place)?], *image)));
        let known: Vec<_> = known.collect();
        let map = homography::homography(&known)
            .with_context(|| format!("{} targets identified, four or more wanted", known.len()))?;
        let seen: Vec<_> = object.iter().map(|place| homography::apply(&map, *place)).collect();
        let nearest = |at: &Vector2<f64>, all: &[Vector2<f64>]| {
            let off = |i: &usize| (all[*i] - at).norm();
            (0..all.len()).min_by(|a, b| off(a).total_cmp(&off(b))).filter(|i| off(i) < NEAR)
        };
        // One to one: each must be the other's nearest.
        let mutual = |(i, at)| nearest(at, &seen).filter(|place| nearest(&seen[*place], &image) == Some(i));
        places = image.iter().enumerate().map(mutual).collect();
    }
    Ok(places)
}

/// Farthest that a target may be from where the homography puts it, px.
const NEAR: f64 = 10.0;
