//! Time of a frame on the desktop, one thread, everything up to the report: `cargo bench -p concentric-host`.
//!
//! Absolute times say little on a shared machine, so the time that it takes to add up the bytes of a frame stands beside
//! those of the frames of its size.

use std::hint::black_box;

use concentric::report::{Detail, Report, max_len};
use concentric::{Detector, Image, Settings, Storage, TargetSpec};
use concentric_host::workload::{SIZES, crowds};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};

const MAX_TARGETS: usize = 64;

fn frames(criterion: &mut Criterion) {
    let mut storage = Box::<Storage<1280, 160, 3600>>::default();
    let mut report = Report::<MAX_TARGETS>::new(Detail::Normal);
    let mut bytes = [0; max_len(MAX_TARGETS, Detail::Normal)];
    for (width, height) in SIZES {
        let mut group = criterion.benchmark_group(format!("{width}x{height}"));
        group.sample_size(20);
        group.throughput(Throughput::Bytes(u64::from(width * height)));
        let pictures = crowds(width, height).expect("frames of the workload");
        group.bench_function("sum of bytes", |bencher| {
            let pixels = &pictures[0].pixels;
            bencher.iter(|| black_box(pixels).iter().fold(0u64, |sum, &level| sum + u64::from(level)));
        });
        for picture in &pictures {
            let image =
                Image::new(&picture.pixels, width as u16, height as u16).expect("size of the picture");
            group.bench_with_input(BenchmarkId::from_parameter(&picture.name), &image, |bencher, image| {
                let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
                bencher.iter(|| {
                    report.begin(1);
                    let mut found = detector.detect(black_box(image)).expect("size of the picture");
                    for target in found.by_ref() {
                        report.push(&target);
                    }
                    report.finish(&found.summary(), &mut bytes).expect("room for the report").len()
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
