//! Writes the frames of `cargo xtask bench` and what the desktop finds in them. `cargo xtask bench` runs this.

use std::env;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use concentric::report::{Report, max_len};
use concentric::track::Tracker;
use concentric::{Detector, Effort, Image, Region, Run, Settings, Summary};
use concentric_host::link::runs;
use concentric_host::picture::Picture;
use concentric_host::workload::{RADII, SIZES, crowds, lone};
use serde::Serialize;

#[path = "../../examples/bench/src/job.rs"]
mod job;

use job::{
    CONTRAST, DETAIL, FULL, Large, MAGIC, MAX_TARGETS, MOST, Medium, OWN_PIXELS, QUICK, SAME_PIXELS,
    SETTINGS, Small, WHOLE, WITH_RUNS,
};

/// Between the targets and the paper of the rendered frames.
const THRESHOLD: u8 = 125;

/// Frames that are also measured with little room for work, ...
const BOUNDED: [&str; 6] =
    ["60 targets", "clutter", "noise", "checkerboard 1 px", "checkerboard 4 px", "checkerboard 6 px"];
/// ... and pixels for each run of those between the usual bound and that.
const BOUNDS: [u16; 2] = [32, 64];

/// A frame and what the desktop sends for it.
#[derive(Clone, Serialize)]
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
    #[serde(skip)]
    px_per_run: u16,
    #[serde(skip)]
    effort: Effort,
    /// Where it is searched, if not as a whole.
    #[serde(skip)]
    regions: Option<Vec<Region>>,
    /// Runs of its rows, if known.
    #[serde(skip)]
    runs: Option<Vec<Vec<Run>>>,
}

fn main() -> Result<()> {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let (folder, sizes, scene) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [folder] => (folder, &SIZES[..], ""),
        [folder, "--quick"] => (folder, &SIZES[..1], ""),
        [folder, "--scene", scene] => (folder, &SIZES[..], scene),
        _ => bail!("usage: bench FOLDER [--quick | --scene NAME]"),
    };
    let folder = Path::new(folder);
    let mut pictures = Vec::new();
    for &(width, height) in sizes {
        pictures.extend(crowds(width, height)?);
    }
    for radius in RADII {
        pictures.push(lone(radius)?);
    }
    let mut frames = Vec::new();
    for frame in pictures.into_iter().map(Frame::new) {
        if frame.scene == "60 targets" && frame.width < 1280 {
            frames.push(frame.tracked("60 of 60 tracked", MAX_TARGETS)?);
            frames.push(frame.tracked("6 of 60 tracked", 6)?);
            frames.push(frame.with_runs());
        }
        if frame.scene == "60 targets" || frame.scene.starts_with("radius") {
            frames.push(frame.quick());
        }
        if BOUNDED.contains(&frame.scene.as_str()) {
            let between = ["60 targets", "checkerboard 6 px"].contains(&frame.scene.as_str());
            let between = between && frame.width == SIZES[0].0;
            let bounds = BOUNDS.into_iter().filter(|_| between).chain([Settings::BOUNDED_PX_PER_RUN]);
            frames.extend(bounds.map(|px_per_run| frame.bounded(px_per_run)));
        }
        frames.push(frame);
    }
    frames.retain(|frame| frame.name().contains(scene));
    if frames.is_empty() {
        bail!("no frame has `{scene}` in its name, as `60 targets 320x240` or `radius 30 320x240`");
    }
    let mut bytes = Vec::new();
    for word in [MAGIC, frames.len().try_into()?] {
        bytes.extend(word.to_le_bytes());
    }
    for (number, frame) in (0..).zip(&mut frames) {
        frame.measure(number).with_context(|| frame.scene.clone())?;
    }
    for (i, frame) in frames.iter().enumerate() {
        frame.write(i.checked_sub(1).map(|before| &frames[before]), &mut bytes);
    }
    fs::write(folder.join("frames.bin"), bytes)?;
    fs::write(folder.join("frames.json"), serde_json::to_string(&frames)?)?;
    Ok(())
}

impl Frame {
    fn new(picture: Picture) -> Self {
        let Picture { name, width, height, pixels } = picture;
        let (width, height) = (width as u32, height as u32);
        Self {
            scene: name,
            width,
            height,
            targets: 0,
            dropped: 0,
            report: String::new(),
            pixels,
            px_per_run: Settings::DEFAULT_PX_PER_RUN,
            effort: Effort::Full,
            regions: None,
            runs: None,
        }
    }

    fn name(&self) -> String {
        format!("{} {}x{}", self.scene, self.width, self.height)
    }

    /// The same when `most` of its targets are followed from the frame before.
    fn tracked(&self, scene: &str, most: usize) -> Result<Self> {
        let mut storage = Box::<Large>::default();
        let mut detector = Detector::new(SETTINGS, &mut storage);
        let image = Image::new(&self.pixels, self.width.try_into()?, self.height.try_into()?)?;
        let mut tracker = Tracker::<MOST>::new().whole_every(10);
        tracker.begin();
        for target in detector.detect(&image)?.take(most) {
            tracker.follow(&target);
        }
        tracker.begin();
        let (width, height) = image.size();
        let regions = tracker.regions(width, height).map(|regions| regions.to_vec());
        Ok(Self { scene: scene.to_owned(), regions, ..self.clone() })
    }

    /// The same when logic beside the processor finds the runs. A threshold for all is enough for it here.
    fn with_runs(&self) -> Self {
        let runs = self.pixels.chunks(self.width as usize).map(|row| runs(row, THRESHOLD)).collect();
        Self { scene: "60 targets with runs".to_owned(), runs: Some(runs), ..self.clone() }
    }

    /// The same with another bound of the work.
    fn bounded(&self, px_per_run: u16) -> Self {
        Self { scene: format!("{}, {px_per_run} px a run", self.scene), px_per_run, ..self.clone() }
    }

    /// The same with less effort for each target.
    fn quick(&self) -> Self {
        Self { scene: format!("{}, quick", self.scene), effort: Effort::Quick, ..self.clone() }
    }

    fn settings(&self) -> Settings {
        SETTINGS.px_per_run(self.px_per_run).effort(self.effort)
    }

    /// As `job.rs` says, after the frame `before`.
    fn write(&self, before: Option<&Self>, bytes: &mut Vec<u8>) {
        let mut word = |word: u32| bytes.extend(word.to_le_bytes());
        word(self.width);
        word(self.height);
        word(self.px_per_run.into());
        word(if self.effort == Effort::Quick { QUICK } else { FULL });
        word(self.regions.as_ref().map_or(WHOLE, |regions| regions.len() as u32));
        for region in self.regions.iter().flatten() {
            for place in [region.top, region.bottom, region.left, region.right] {
                word(place.into());
            }
        }
        if before.is_some_and(|before| before.pixels == self.pixels) {
            word(SAME_PIXELS);
        } else {
            word(OWN_PIXELS);
            bytes.extend(&self.pixels);
        }
        let mut word = |word: u32| bytes.extend(word.to_le_bytes());
        word(if self.runs.is_some() { WITH_RUNS } else { WHOLE });
        for row in self.runs.iter().flatten() {
            word(row.len() as u32);
            row.iter().for_each(|run| word(u32::from(run.start) | u32::from(run.end) << 16));
        }
    }

    /// Measures the frame in the storage that the firmware takes for it.
    fn measure(&mut self, number: u32) -> Result<()> {
        match self.width {
            0..=320 => self.detect(number, Detector::new(self.settings(), &mut Box::<Small>::default())),
            321..=640 => self.detect(number, Detector::new(self.settings(), &mut Box::<Medium>::default())),
            _ => self.detect(number, Detector::new(self.settings(), &mut Box::<Large>::default())),
        }
    }

    fn detect(&mut self, number: u32, mut detector: Detector<'_>) -> Result<()> {
        let mut report = Report::<MAX_TARGETS>::new(DETAIL);
        report.begin(number);
        let (width, height) = (self.width.try_into()?, self.height.try_into()?);
        let mut scan = match &self.regions {
            Some(regions) => {
                // As a head would have: the noise is known from a whole frame.
                let image = Image::new(&self.pixels, width, height)?;
                detector.detect(&image)?.for_each(drop);
                detector.begin(width, height)?.within(regions)?
            }
            None => detector.begin(width, height)?,
        };
        for (y, row) in self.pixels.chunks(self.width as usize).enumerate() {
            let targets = match &self.runs {
                Some(runs) => scan.push_row_with_runs(row, &runs[y], CONTRAST)?,
                None => scan.push_row(row)?,
            };
            targets.for_each(|target| report.push(&target));
        }
        let mut rest = scan.finish()?;
        rest.by_ref().for_each(|target| report.push(&target));
        let summary: Summary = rest.summary();
        println!("{}: {:?}", self.name(), summary.used);
        let mut bytes = [0; max_len(MAX_TARGETS, DETAIL)];
        self.report = report.finish(&summary, &mut bytes)?.iter().map(|byte| format!("{byte:02x}")).collect();
        self.targets = summary.targets;
        self.dropped = summary.dropped.runs + summary.dropped.outlines + summary.dropped.crossings;
        Ok(())
    }
}
