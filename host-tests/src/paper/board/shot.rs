//! A picture of the board to targets with their places on it.

use anyhow::{Context, Result};
use concentric::{Camera, Compensation, Image, Position, Settings, Target, TargetSpec, code, coplanar::pool};

use super::scene::Stage;
use crate::{
    detect,
    layout::Layout,
    matching::{Correspondence, Measured, correspond},
};

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
            Self::Ratio | Self::Camera(_) => spec(layout)?,
        };
        let spec = if layout.light { spec.light() } else { spec };
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

/// The ratios that all targets of the layout share; any if they do not.
fn spec(layout: &Layout) -> Result<TargetSpec> {
    let ratios = |radii: &[f64]| -> Vec<f32> {
        radii.iter().skip(1).zip(radii.first()).map(|(inner, outer)| (inner / outer) as f32).collect()
    };
    let mut all = layout.targets.iter().map(|target| ratios(&target.radii));
    let first = all.next().context("a layout has targets")?;
    Ok(if all.all(|other| other == first) { TargetSpec::circles(&first)? } else { TargetSpec::any() })
}

impl Shot {
    /// A picture of `stage`; `noise` and `seed` are for a rendered one.
    ///
    /// # Errors
    /// A picture on which too few coded markers are read; names it.
    pub fn new(stage: &Stage, noise: f64, seed: u64, told: Told) -> Result<Self> {
        Self::identified(stage, noise, seed, told).with_context(|| stage.name.clone())
    }

    fn identified(stage: &Stage, noise: f64, seed: u64, told: Told) -> Result<Self> {
        let picture = stage.picture(noise, seed)?;
        let settings = told.settings(&stage.layout)?;
        let mut targets = detect::run(&picture, settings)?.targets;
        let size = (u16::try_from(picture.width)?, u16::try_from(picture.height)?);
        let image = Image::new(&picture.pixels, size.0, size.1)?;
        targets.iter_mut().for_each(|target| _ = code::read(&image, &settings, target));
        let mut pooled = targets.clone();
        // Where they share no plane they stay as they were.
        let _ = pool(&mut pooled, settings.camera.as_ref());
        let measured: Vec<_> = targets.iter().map(Measured::new).collect();
        let size = [u32::from(size.0), u32::from(size.1)];
        let Correspondence { pairs, unmatched, .. } = correspond(&measured, &stage.layout, size)?;
        let found = pairs.iter().filter_map(|pair| {
            let (target, pooled) = (targets.get(pair.measured)?, pooled.get(pair.measured)?);
            Some(Found { index: pair.target, target: target.clone(), pooled: pooled.centre })
        });
        Ok(Self { found: found.collect(), unmatched: unmatched.len() })
    }
}
