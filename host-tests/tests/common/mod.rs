//! What the tests share.

// Each test uses a part of it.
#![allow(dead_code)]

pub mod boards;
pub mod golden;

use concentric::{Detector, Image, Settings, Storage, Summary, Target, TargetSpec};
use concentric_host::render::{Frame, Truth};

/// Storage for everything that the tests show.
pub type Desktop = Storage<4096, 4096, 60000>;

/// Runs the library on a frame.
pub fn detect(frame: &Frame, spec: TargetSpec) -> (Vec<Target>, Summary) {
    detect_with(frame, Settings::new(spec))
}

/// The same with any settings.
pub fn detect_with(frame: &Frame, settings: Settings) -> (Vec<Target>, Summary) {
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings, &mut storage);
    let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).expect("size of a frame");
    let mut detection = detector.detect(&image).expect("size of a frame");
    let targets = detection.by_ref().collect();
    (targets, detection.summary())
}

/// True minus found centre of each target of the truth that was found within 2 px, and the number of targets found
/// that are nowhere in the truth.
pub fn errors<'t>(targets: &'t [Target], truth: &Truth) -> (Vec<(f64, f64, &'t Target)>, usize) {
    let place = |t: &Target| {
        let scale = f64::from(concentric::Position::SCALE);
        (f64::from(t.centre.x) / scale, f64::from(t.centre.y) / scale)
    };
    let errors: Vec<_> = truth
        .targets
        .iter()
        .filter_map(|truth| {
            let near = targets.iter().map(|t| (place(t), t)).map(|((x, y), t)| (truth.x - x, truth.y - y, t));
            near.filter(|(dx, dy, _)| dx.hypot(*dy) < 2.0)
                .min_by(|a, b| a.0.hypot(a.1).total_cmp(&b.0.hypot(b.1)))
        })
        .collect();
    let false_targets = targets.len().saturating_sub(errors.len());
    (errors, false_targets)
}
