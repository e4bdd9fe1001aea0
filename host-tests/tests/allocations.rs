//! A frame, from its rows to the bytes of its report, takes nothing from the heap.

use allocation_counter::measure;
use concentric::report::{Detail, Report, max_len};
use concentric::{Compensation, Detector, Image, Settings, Storage, TargetSpec};
use concentric_host::picture::Picture;
use concentric_host::workload::{crowds, lone};

const MAX_TARGETS: usize = 64;

/// Heap allocations of a frame; `extra` runs with it.
fn allocations(picture: &Picture, settings: Settings, extra: impl Fn()) -> u64 {
    let mut storage = Box::<Storage<640, 128, 1800>>::default();
    let mut report = Report::<MAX_TARGETS>::new(Detail::Full);
    let mut bytes = [0; max_len(MAX_TARGETS, Detail::Full)];
    let image = Image::new(&picture.pixels, picture.width as u16, picture.height as u16).expect("size");
    let mut detector = Detector::new(settings, &mut storage);
    let counted = measure(|| {
        report.begin(1);
        let mut found = detector.detect(&image).expect("size");
        for target in found.by_ref() {
            report.push(&target);
        }
        report.finish(&found.summary(), &mut bytes).expect("room for the report");
        extra();
    });
    counted.count_total
}

#[test]
fn no_frame_takes_from_the_heap() {
    let mut pictures = crowds(640, 480).expect("frames");
    pictures.push(lone(30).expect("frame"));
    for picture in &pictures {
        for compensation in [Compensation::Exact, Compensation::Auto, Compensation::Eq7] {
            let settings = Settings::new(TargetSpec::any()).compensation(compensation);
            assert_eq!(allocations(picture, settings, || {}), 0, "{} {compensation:?}", picture.name);
        }
    }
}

#[test]
fn an_allocation_would_be_counted() {
    let picture = lone(30).expect("frame");
    let settings = Settings::new(TargetSpec::any());
    let extra = || _ = std::hint::black_box(Box::new(1));
    assert_eq!(allocations(&picture, settings, extra), 1);
}
