//! A picture of the board to targets with their places on it.

use anyhow::Result;
use concentric::{
    Camera, Compensation, Detector, Image, Position, Settings, Storage, Target, TargetSpec, code,
    coplanar::pool,
};

use super::scene::Stage;
use crate::{
    layout::Layout,
    matching::{Correspondence, Measured, correspond},
    paper::simulation::RATIO,
};

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
        let measured: Vec<_> = targets.iter().map(Measured::new).collect();
        let size = [stage.camera.width, stage.camera.height];
        let Correspondence { pairs, unmatched, .. } = correspond(&measured, &stage.layout, size)?;
        let found = pairs.iter().filter_map(|pair| {
            let (target, pooled) = (targets.get(pair.measured)?, pooled.get(pair.measured)?);
            Some(Found { index: pair.target, target: target.clone(), pooled: pooled.centre })
        });
        Ok(Self { found: found.collect(), unmatched: unmatched.len() })
    }
}
