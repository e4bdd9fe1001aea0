//! Bytes: of the storage, of the reports.

use concentric::report::{Detail, Report, max_len};
use concentric::{Detector, Dropped, Image, Settings, Storage, Target, TargetSpec};
use concentric_host::render::{Camera, Frame, Scene};

use crate::{
    common::{detect, errors},
    document::{rounded, table},
};

/// A row of the table, after the storage has proved that it is enough for the frame.
fn row<const WIDTH: usize, const OUTLINES: usize, const CROSSINGS: usize>(
    count: usize,
    height: u16,
) -> Vec<String> {
    let mut storage = Box::<Storage<WIDTH, OUTLINES, CROSSINGS>>::default();
    // The bound of the work drops runs of clutter whatever the storage.
    let settings = Settings::new(TargetSpec::any()).px_per_run(0);
    let mut detector = Detector::new(settings, &mut storage);
    let size = format!("{WIDTH} x {height}");
    let (mut outlines, mut crossings) = (0, 0);
    for seed in 0..3 {
        let frame = crowd(count, WIDTH as u32, u32::from(height), seed);
        let image = Image::new(&frame.pixels, WIDTH as u16, height).expect("size of a frame");
        let mut detection = detector.detect(&image).expect("size of a frame");
        let targets: Vec<_> = detection.by_ref().collect();
        let summary = detection.summary();
        assert_eq!(summary.dropped, Dropped::default(), "{size}: the storage is too small");
        (outlines, crossings) = (outlines.max(summary.used.outlines), crossings.max(summary.used.crossings));
        assert_eq!(errors(&targets, &frame.truth).0.len(), count, "{size}: targets missed");
    }
    let bytes = Storage::<WIDTH, OUTLINES, CROSSINGS>::BYTES;
    let name = format!("`Storage<{WIDTH}, {OUTLINES}, {CROSSINGS}>`");
    let used = format!("{outlines} and {crossings}");
    vec![name, bytes.to_string(), format!("{:.1}", bytes as f64 / 1024.0), count.to_string(), size, used]
}

/// Targets and as many decoys; without decoys where these would take long to render.
fn crowd(count: usize, width: u32, height: u32, seed: u64) -> Frame {
    let paper = Camera::paper();
    let clutter = width <= paper.width;
    Scene::many(count, width, height, clutter, seed).expect("the targets fit").render(seed)
}

pub fn memory() -> String {
    let rows = [
        row::<320, 32, 900>(12, 240),
        row::<640, 64, 1600>(60, 480),
        row::<1280, 64, 1800>(60, 1024),
        row::<4096, 64, 1800>(60, 3072),
    ];
    table(
        &["storage", "bytes", "KiB", "enough for targets", "in a frame of", "outlines and crossings used"],
        &rows,
    )
}

/// Length of the message with these targets.
fn sent(frame: &Frame, targets: &[Target], detail: Detail) -> usize {
    let (_, summary) = detect(frame, TargetSpec::any());
    let mut report = Report::<60>::new(detail);
    targets.iter().for_each(|target| report.push(target));
    report.finish(&summary, &mut [0; max_len(60, Detail::Full)]).expect("a buffer that is large enough").len()
}

pub fn report() -> String {
    let frame = crowd(60, 1280, 1024, 0);
    let (targets, _) = detect(&frame, TargetSpec::any());
    let rows = [0, 1, 60].map(|count| {
        let lengths = [Detail::Terse, Detail::Normal, Detail::Full].map(|detail| {
            let sent = sent(&frame, &targets[..count], detail);
            format!("{} (at most {})", rounded(sent as f64), max_len(count, detail))
        });
        [&[count.to_string()], &lengths[..]].concat()
    });
    table(&["targets", "terse", "normal", "full"], &rows)
}
