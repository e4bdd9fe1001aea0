//! From pictures and recorded reports to views.

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, bail, ensure};
use concentric::{Compensation, Settings, TargetSpec, report::Message};

use super::{MIN_POINTS, Point, View};
use crate::{
    detect,
    layout::Layout,
    matching::{Correspondence, Measured, correspond},
    monitor,
    picture::Picture,
};

/// Endings of pictures that are taken from a folder.
const ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "pgm"];

/// How targets are measured.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// The targets.
    pub layout: Layout,
    /// For the detector.
    pub settings: Settings,
    /// Whether centres are those of the outer ellipses, to be corrected with pose and radius.
    pub ellipses: bool,
    /// Whether targets are measured again on the pixels.
    pub refine: bool,
}

/// A view and which target is which in it.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The view.
    pub view: View,
    /// Which is which.
    pub correspondence: Correspondence,
}

impl Measuring {
    /// For the targets of `layout`, whose ratios of radii the detector takes if they all have the same.
    ///
    /// # Errors
    /// Targets or ids that the library does not know.
    pub fn new(layout: Layout) -> Result<Self> {
        let ratios = |radii: &[f64]| -> Vec<f32> {
            radii.iter().skip(1).map(|radius| (radius / radii[0]) as f32).collect()
        };
        let mut all = layout.targets.iter().map(|target| ratios(&target.radii));
        let first = all.next().unwrap_or_default();
        let near = |other: Vec<f32>| {
            other.len() == first.len() && other.iter().zip(&first).all(|(a, b)| (a - b).abs() < 1e-3)
        };
        let spec = if !first.is_empty() && all.all(near) {
            TargetSpec::circles(&first).unwrap_or(TargetSpec::any())
        } else {
            TargetSpec::any()
        };
        let mut settings = Settings::new(if layout.light { spec.light() } else { spec });
        settings.code = layout.settings_code()?;
        Ok(Self { layout, settings, ellipses: false, refine: false })
    }

    /// The same with another form of the centre.
    pub fn compensation(mut self, compensation: Compensation) -> Self {
        self.settings = self.settings.compensation(compensation);
        self
    }

    /// The view of a picture.
    ///
    /// # Errors
    /// A picture that the library refuses, or in which too few targets are found to tell which is which.
    pub fn picture(&self, picture: &Picture) -> Result<Seen> {
        let mut targets = detect::run(picture, self.settings)?.targets;
        if self.refine {
            // One that cannot be refined is as good as it was found.
            let _ = detect::command::refine(picture, &self.settings, &mut targets)?;
        }
        let measured: Vec<_> = targets.iter().map(Measured::new).collect();
        let size = [u32::try_from(picture.width)?, u32::try_from(picture.height)?];
        self.view(picture.name.clone(), size, &measured)
    }

    /// The views of a recording of reports: of every frame the measured targets, and the view or why there is none.
    ///
    /// # Errors
    /// Bytes without a report.
    pub fn recording(&self, name: &str, bytes: &[u8]) -> Result<Vec<Result<Seen>>> {
        let mut decoder = monitor::decoder();
        let mut views = Vec::new();
        for &byte in bytes {
            // What is no message is skipped: the next separator begins anew.
            let Some(Ok(Message::Frame(frame))) = decoder.push(byte) else { continue };
            let measured: Vec<_> = frame.targets().filter_map(|entry| Measured::reported(&entry)).collect();
            let size = [frame.head.width, frame.head.height].map(u32::from);
            views.push(self.view(format!("{name} frame {}", frame.head.seq), size, &measured));
        }
        ensure!(!views.is_empty(), "neither a picture nor a recording of reports");
        Ok(views)
    }

    fn view(&self, name: String, size: [u32; 2], measured: &[Measured]) -> Result<Seen> {
        let correspondence = correspond(measured, &self.layout, size)?;
        let point = |pair: &crate::matching::Pair| {
            let (target, measured) = (&self.layout.targets[pair.target], &measured[pair.measured]);
            Point {
                object: target.position,
                image: measured.centre,
                covariance: measured.covariance,
                radius: if self.ellipses { target.radii.first().copied().unwrap_or(0.0) } else { 0.0 },
            }
        };
        let points: Vec<_> = correspondence.pairs.iter().map(point).collect();
        ensure!(
            points.len() >= MIN_POINTS,
            "{} targets are where the layout has one; wanted are {MIN_POINTS}",
            points.len()
        );
        Ok(Seen { view: View { name, size, points }, correspondence })
    }
}

/// What a file holds.
#[derive(Clone, Debug)]
pub enum Input {
    /// A picture.
    Picture(Picture),
    /// Bytes that are no picture: perhaps reports.
    Recording(Vec<u8>),
}

impl Input {
    /// Reads a file; which kind it is its content tells.
    ///
    /// # Errors
    /// A file that cannot be read, or a damaged picture.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).context("cannot be read")?;
        if image::guess_format(&bytes).is_ok() {
            return Ok(Self::Picture(Picture::decode(path.to_string_lossy(), &bytes)?));
        }
        Ok(Self::Recording(bytes))
    }
}

/// The files meant: a folder stands for the pictures in it, by name.
///
/// # Errors
/// A folder that cannot be read or has no pictures.
pub fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let name = path.display();
        let entries = fs::read_dir(path).with_context(|| format!("{name}: cannot be read"))?;
        let mut pictures: Vec<_> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| {
                let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
                ENDINGS.iter().any(|known| ending.as_deref() == Some(known.as_ref()))
            })
            .collect();
        if pictures.is_empty() {
            bail!("{name}: no pictures in this folder; taken are names that end in {}", ENDINGS.join(", "));
        }
        pictures.sort();
        files.append(&mut pictures);
    }
    Ok(files)
}
