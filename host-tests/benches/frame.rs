//! Time of a frame on the desktop: `cargo bench -p concentric-host`.
//!
//! Absolute times say little on a shared machine, so each is also given as a multiple of the time that it takes to add up
//! the bytes of the same frame, measured in the same run.

use concentric::{Detector, Image, Settings, Storage, TargetSpec};
use concentric_host::render::Scene;
use std::hint::black_box;
use std::time::{Duration, Instant};

const RUNS: u32 = 200;

fn main() {
    // Cargo passes `--bench`; under `cargo test` one run shows that it works.
    let runs = if std::env::args().any(|argument| argument == "--bench") { RUNS } else { 1 };
    let mut empty = Scene::many(1, 1280, 1024, false, 0).expect("one target fits");
    empty.targets.clear();
    let mut noise = empty.clone();
    noise.photometry.noise = 60.0;
    let plain = Scene::many(60, 1280, 1024, false, 0).expect("sixty targets fit");
    let crowd = Scene::many(60, 1280, 1024, true, 0).expect("sixty targets fit");
    let small = Scene::many(60, 640, 480, true, 0).expect("sixty targets fit");
    println!("frame                              targets  best ms  median ms  x sum of bytes");
    for (name, scene) in [
        ("1280 x 1024, empty, noise 2", &empty),
        ("1280 x 1024, 60 annuli", &plain),
        ("1280 x 1024, 60 annuli, clutter", &crowd),
        ("640 x 480, 60 annuli, clutter", &small),
        ("1280 x 1024, noise 60", &noise),
    ] {
        measure(name, scene, runs);
    }
}

fn measure(name: &str, scene: &Scene, runs: u32) {
    let frame = scene.render(0);
    let mut storage = Box::<Storage<4096, 4096, 60000>>::default();
    let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
    let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).expect("size of a frame");
    let mut found = 0;
    let (best, median) = times(runs, || found = detector.detect(&image).expect("size of a frame").count());
    let (floor, _) = times(runs, || {
        black_box(frame.pixels.iter().fold(0u64, |sum, &level| sum + u64::from(level)));
    });
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    println!("{name:34} {found:7}  {:7.3}  {:9.3}  {:14.1}", ms(best), ms(median), ms(best) / ms(floor));
}

/// Best and median time.
fn times(runs: u32, mut work: impl FnMut()) -> (Duration, Duration) {
    let mut times: Vec<_> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed()
        })
        .collect();
    times.sort();
    (times[0], times[times.len() / 2])
}
