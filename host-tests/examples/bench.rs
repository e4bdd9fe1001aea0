//! Writes the frames of `cargo xtask bench` and what the desktop finds in them. `cargo xtask bench` runs this.

use std::env;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use concentric::report::{Report, max_len};
use concentric::{Detector, Image, Summary};
use concentric_host::render::{Artwork, Camera, Pose, Scene, Target};
use serde::Serialize;

#[path = "../../examples/bench/src/job.rs"]
mod job;

use job::{DETAIL, Large, MAGIC, MAX_TARGETS, Medium, SETTINGS, Small};

/// Sizes of the frames, px.
const SIZES: [(u32, u32); 3] = [(320, 240), (640, 480), (1280, 1024)];
/// Targets in a full frame, in columns and rows.
const TARGETS: usize = 60;
const COLUMNS: u32 = 10;
/// Outer radius of these, in widths of the frame.
const RADIUS: f64 = 9.0 / 320.0;
/// Focal length, in widths of the frame.
const FOCAL_LENGTH: f64 = 1.5;
/// Radii of lone targets, px.
const RADII: [u32; 3] = [10, 30, 100];
const SEED: u64 = 0;

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
    let mut frames = Vec::new();
    for &(width, height) in sizes {
        crowds(width, height, &mut frames)?;
    }
    for radius in RADII {
        frames.push(Frame::new(format!("radius {radius}"), 320, lone(radius).render(SEED).pixels));
    }
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

/// The scenes whose cost is given for each pixel.
fn crowds(width: u32, height: u32, frames: &mut Vec<Frame>) -> Result<()> {
    let paper = Camera::new(width, height, f64::from(width) * FOCAL_LENGTH);
    // As many targets as the frame has columns of them, so that there is room between them at every size.
    let clutter = Scene::many(TARGETS * width as usize / 1280, width, height, true, SEED)?;
    let side = |cell: usize| {
        let level = move |x: usize, y: usize| if (x / cell + y / cell).is_multiple_of(2) { 30 } else { 220 };
        (0..height as usize).flat_map(move |y| (0..width as usize).map(move |x| level(x, y))).collect()
    };
    let mut state = 1u32;
    let noise = std::iter::repeat_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    });
    let pictures = [
        ("empty", Scene::empty(paper).render(SEED).pixels),
        ("60 targets", board(paper).render(SEED).pixels),
        ("clutter", clutter.render(SEED).pixels),
        ("noise", noise.take((width * height) as usize).collect()),
        ("checkerboard 1 px", side(1)),
        ("checkerboard 4 px", side(4)),
        ("checkerboard 6 px", side(6)),
    ];
    frames.extend(pictures.map(|(scene, pixels)| Frame::new(scene.to_owned(), width, pixels)));
    Ok(())
}

/// Targets in columns and rows; they cover the same share of the frame whatever its size.
fn board(camera: Camera) -> Scene {
    let mut scene = Scene::empty(camera);
    let radius = RADIUS * f64::from(camera.width);
    let rows = TARGETS as u32 / COLUMNS;
    for number in 0..TARGETS as u32 {
        let (column, row) = (number % COLUMNS, number / COLUMNS);
        let place =
            |at: u32, count: u32, size: u32| (f64::from(at) + 0.5) / f64::from(count) * f64::from(size);
        // Every target lies differently on the pixels.
        let shift = |step: f64| (f64::from(number) * step).fract();
        let centre = [
            place(column, COLUMNS, camera.width) + shift(0.618),
            place(row, rows, camera.height) + shift(0.414),
        ];
        scene.targets.push(annulus(&camera, centre, radius));
    }
    scene
}

/// One target of this outer radius, px.
fn lone(radius: u32) -> Scene {
    let mut scene = Scene::empty(Camera::new(320, 240, 320.0 * FOCAL_LENGTH));
    let target = annulus(&scene.camera, [160.3, 120.7], radius.into());
    scene.targets.push(target);
    scene
}

/// An annulus of ratio 0.5 seen at 30 degrees, its centre and outer radius in px.
fn annulus(camera: &Camera, [x, y]: [f64; 2], radius: f64) -> Target {
    let distance = 800.0;
    let outer = radius * distance / camera.f;
    let pose = Pose { x, y, distance, tilt: 30.0, azimuth: 30.0 };
    Target { artwork: Artwork::annulus(outer, outer / 2.0), pose, at: [0.0, 0.0] }
}

impl Frame {
    fn new(scene: String, width: u32, pixels: Vec<u8>) -> Self {
        let height = pixels.len() as u32 / width;
        Self { scene, width, height, targets: 0, dropped: 0, report: String::new(), pixels }
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
        println!(
            "{} {}x{}: {} targets, dropped {:?}, used {:?}",
            self.scene, self.width, self.height, self.targets, summary.dropped, summary.used
        );
        Ok(())
    }
}
