//! The command `detect`: photographs in, true centres out.

pub mod camera;
pub mod command;
mod csv;
mod json;
mod listing;

use std::{
    sync::{Mutex, PoisonError},
    time::{Duration, Instant},
};

use anyhow::Result;
use concentric::{
    Detector, Image, MAX_WIDTH, Rejected, Settings, Storage, Summary, Target, code, coplanar::Plane,
};

use crate::picture::Picture;

/// Room for photographs full of clutter. A static, because it is too large for a thread's stack.
static STORAGE: Mutex<Storage<{ MAX_WIDTH as usize }, 4096, 60_000>> = Mutex::new(Storage::new());

/// What the library made of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The targets, in the order in which they closed.
    pub targets: Vec<Target>,
    /// The candidates that are none.
    pub rejected: Vec<Rejected>,
    /// The plane on which they lie, where that was asked for.
    pub plane: Option<Plane>,
    /// Counts.
    pub summary: Summary,
    /// Time for the detection alone, without reading and decoding the picture.
    pub elapsed: Duration,
}

/// Pushes `picture` through the library, row by row, and reads the codes of the targets if `settings` have one.
///
/// # Errors
/// A picture that the library refuses.
pub fn run(picture: &Picture, settings: Settings) -> Result<Outcome> {
    let mut storage = STORAGE.lock().unwrap_or_else(PoisonError::into_inner);
    let (mut targets, mut rejected) = (Vec::new(), Vec::new());
    let (width, height) = (u16::try_from(picture.width)?, u16::try_from(picture.height)?);
    let start = Instant::now();
    let mut detector = Detector::new(settings, &mut *storage);
    let mut scan = detector.begin_observed(width, height, |one: &Rejected| rejected.push(*one))?;
    for row in picture.rows() {
        targets.extend(scan.push_row(row)?);
    }
    let mut rest = scan.finish()?;
    targets.extend(rest.by_ref());
    let summary = rest.summary();
    let image = Image::new(&picture.pixels, width, height)?;
    for target in &mut targets {
        // One without a code is a target all the same.
        let _ = code::read(&image, &settings, target);
    }
    let elapsed = start.elapsed();
    Ok(Outcome { targets, rejected, plane: None, summary, elapsed })
}
