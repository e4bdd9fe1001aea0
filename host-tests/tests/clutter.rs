//! Pictures that are all clutter: what is dropped is bounded and counted, and targets among it are found.

mod common;

use common::Desktop;
use concentric::{Detector, Image, Settings, Summary, Target, TargetSpec};
use concentric_host::render::{Frame, Scene};
use concentric_host::workload::crowds;

fn run(frame: &Frame, px_per_run: u16) -> (Vec<Target>, Summary) {
    let mut storage = Box::<Desktop>::default();
    let settings = Settings::new(TargetSpec::any()).px_per_run(px_per_run);
    let mut detector = Detector::new(settings, &mut storage);
    let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).expect("a frame");
    let mut detection = detector.detect(&image).expect("a frame that fits");
    let targets = detection.by_ref().collect();
    (targets, detection.summary())
}

/// Twelve targets; right of `from` the picture is `level` instead.
fn beside(from: usize, level: impl Fn(usize, usize) -> u8) -> (Frame, usize) {
    let mut frame = Scene::many(12, 640, 480, false, 3).expect("twelve fit").render(3);
    let width = frame.width;
    for (i, pixel) in frame.pixels.iter_mut().enumerate().filter(|(i, _)| i % width >= from) {
        *pixel = level(i % width, i / width);
    }
    let whole = frame.truth.targets.iter().filter(|target| {
        let outer = &target.circles[0];
        target.x + outer.ellipse.a + 4.0 < from as f64
    });
    let whole = whole.count();
    (frame, whole)
}

fn noise(x: usize, y: usize) -> u8 {
    let mut hash = (x as u64) << 32 | y as u64;
    for _ in 0..2 {
        hash = (hash ^ hash >> 29).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
    // Of few levels, so that much of it passes for edges.
    if hash >> 63 == 0 { 30 } else { 220 }
}

#[test]
fn targets_left_of_noise_boards_and_stripes_are_found() {
    let board = |x: usize, y: usize| if (x / 2 + y / 2).is_multiple_of(2) { 20 } else { 220 };
    let stripes = |x: usize, _: usize| if x % 7 < 3 { 20 } else { 220 };
    let bars = |_: usize, y: usize| if y % 9 < 4 { 20 } else { 220 };
    for (what, level) in [
        ("noise", &noise as &dyn Fn(usize, usize) -> u8),
        ("board", &board),
        ("stripes", &stripes),
        ("bars", &bars),
    ] {
        let (frame, whole) = beside(416, level);
        let (targets, summary) = run(&frame, Settings::DEFAULT_PX_PER_RUN);
        println!("{what}: {} of {whole}, {:?}", targets.len(), summary.dropped);
        assert!(whole >= 4, "no test");
        assert!(targets.len() >= whole, "{what}: {} of {whole}", targets.len());
        assert!(summary.dropped.runs > 0 || what != "noise", "{what}");
    }
}

/// A frame of nothing but runs: each pixel of `period` x `period` px squares turns over.
fn squares(width: usize, height: usize, period: usize) -> Frame {
    let mut frame = Scene::many(1, width as u32, height as u32, false, 1).expect("one fits").render(1);
    let turned = |i: usize| (i % width / period + i / width / period).is_multiple_of(2);
    frame.pixels.iter_mut().enumerate().for_each(|(i, pixel)| *pixel = if turned(i) { 20 } else { 220 });
    frame
}

/// Without the bound nothing of a picture is dropped for its runs; the tighter it is, the more, and every time the same.
#[test]
fn runs_beyond_the_bound_are_dropped_and_counted() {
    for frame in [squares(320, 240, 9), squares(640, 480, 11)] {
        let dropped = |px_per_run: u16| run(&frame, px_per_run).1.dropped.runs;
        let counts = [0, 8, 32, 128].map(dropped);
        println!("dropped with 0, 8, 32, 128 px for each run: {counts:?}");
        assert!(counts.is_sorted() && counts[3] > counts[0], "{counts:?}");
        assert_eq!(dropped(32), counts[2]);
    }
}

/// A tight bound has room for what its documentation says, and tells what it drops.
#[test]
fn targets_within_a_tight_bound_are_found() {
    let found = |(number, width, height), px_per_run| {
        let frames =
            (0..10).map(|seed| Scene::many(number, width, height, false, seed).expect("room").render(seed));
        frames.map(|frame| run(&frame, px_per_run)).fold((0, 0), |(targets, dropped), (found, summary)| {
            (targets + found.len(), dropped + summary.dropped.runs + summary.dropped.crossings)
        })
    };
    for few in [(4, 640, 480), (12, 1280, 1024)] {
        assert_eq!(found(few, Settings::BOUNDED_PX_PER_RUN).0, 10 * few.0);
    }
    let (targets, dropped) = found((12, 320, 240), Settings::BOUNDED_PX_PER_RUN);
    assert!(targets < 120 && dropped > 0, "{targets} {dropped}");
    for (width, height) in [(640, 480), (1280, 1024)] {
        let board = crowds(width, height).expect("frames").swap_remove(1);
        let frame = Frame { pixels: board.pixels, ..squares(width as usize, height as usize, 9) };
        assert_eq!(run(&frame, 32).0.len(), 60, "{width} px");
    }
}

/// The bound that is set at first costs no target on a crowded board.
#[test]
fn a_crowded_board_keeps_within_the_bound() {
    let frame = Scene::many(60, 320, 240, false, 5);
    let frame = frame.or_else(|_| Scene::many(40, 320, 240, false, 5)).expect("forty fit").render(5);
    let (bounded, _) = run(&frame, Settings::DEFAULT_PX_PER_RUN);
    let (free, _) = run(&frame, 0);
    assert_eq!(bounded, free);
    // Teeth: a bound that is far too tight does.
    assert!(run(&frame, 400).0.len() < free.len());
}
