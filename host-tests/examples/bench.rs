//! Writes the frames of `cargo xtask bench` and what the desktop finds in them. `cargo xtask bench` runs this.

use std::env;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use concentric::report::{Report, max_len};
use concentric::{Detector, Image, Summary};
use concentric_host::picture::Picture;
use concentric_host::workload::{RADII, SIZES, crowds, lone};
use serde::Serialize;

#[path = "../../examples/bench/src/job.rs"]
mod job;

use job::{DETAIL, Large, MAGIC, MAX_TARGETS, Medium, SETTINGS, Small};

/// A frame and what the desktop sends for it.
#[derive(Serialize)]
struct Frame {
    scene: String,
    width: u32,
    height: u32,
    targets: u32,
    /// Runs, outlines and crossings that did not fit.
    dropped: u32,
    /// Bytes of the report, in hexadecimal digits.
    report: String,
    #[serde(skip)]
    pixels: Vec<u8>,
}

fn main() -> Result<()> {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let (folder, sizes) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [folder] => (folder, &SIZES[..]),
        [folder, "--quick"] => (folder, &SIZES[..1]),
        _ => bail!("usage: bench FOLDER [--quick]"),
    };
    let folder = Path::new(folder);
    let mut pictures = Vec::new();
    for &(width, height) in sizes {
        pictures.extend(crowds(width, height)?);
    }
    for radius in RADII {
        pictures.push(lone(radius)?);
    }
    let mut frames: Vec<Frame> = pictures.into_iter().map(Frame::new).collect();
    let mut bytes = Vec::new();
    for word in [MAGIC, frames.len().try_into()?] {
        bytes.extend(word.to_le_bytes());
    }
    for (number, frame) in (0..).zip(&mut frames) {
        frame.measure(number).with_context(|| frame.scene.clone())?;
        bytes.extend([frame.width, frame.height].map(u32::to_le_bytes).as_flattened());
        bytes.extend(&frame.pixels);
    }
    fs::write(folder.join("frames.bin"), bytes)?;
    fs::write(folder.join("frames.json"), serde_json::to_string(&frames)?)?;
    Ok(())
}

impl Frame {
    fn new(picture: Picture) -> Self {
        let Picture { name, width, height, pixels } = picture;
        let (width, height) = (width as u32, height as u32);
        Self { scene: name, width, height, targets: 0, dropped: 0, report: String::new(), pixels }
    }

    /// Measures the frame in the storage that the firmware takes for it.
    fn measure(&mut self, number: u32) -> Result<()> {
        match self.width {
            0..=320 => self.detect(number, Detector::new(SETTINGS, &mut Box::<Small>::default())),
            321..=640 => self.detect(number, Detector::new(SETTINGS, &mut Box::<Medium>::default())),
            _ => self.detect(number, Detector::new(SETTINGS, &mut Box::<Large>::default())),
        }
    }

    fn detect(&mut self, number: u32, mut detector: Detector<'_>) -> Result<()> {
        let image = Image::new(&self.pixels, self.width.try_into()?, self.height.try_into()?)?;
        let mut report = Report::<MAX_TARGETS>::new(DETAIL);
        report.begin(number);
        let mut found = detector.detect(&image)?;
        for target in found.by_ref() {
            report.push(&target);
        }
        let summary: Summary = found.summary();
        let mut bytes = [0; max_len(MAX_TARGETS, DETAIL)];
        self.report = report.finish(&summary, &mut bytes)?.iter().map(|byte| format!("{byte:02x}")).collect();
        self.targets = summary.targets;
        self.dropped = summary.dropped.runs + summary.dropped.outlines + summary.dropped.crossings;
        Ok(())
    }
}
