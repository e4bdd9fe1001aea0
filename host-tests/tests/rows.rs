//! The row interface: wrong use, small buffers, and pictures that are no pictures.

mod common;

use common::{Desktop, detect};
use concentric::{Detector, FrameError, Image, RowError, Settings, Storage, Summary, Target, TargetSpec};
use concentric_host::render::{Frame, Scene};

fn ring() -> Settings {
    Settings::new(TargetSpec::ring(0.5).expect("0.5 is a ratio"))
}

/// One target in a small frame, without noise.
fn small_frame() -> Frame {
    let mut scene = Scene::single(6.0, 30.0, 20.0, [0.2, -0.3]);
    scene.photometry.noise = 0.0;
    crop(&scene.render(1), 96)
}

/// The middle of a frame; its truth is no longer that of the picture.
fn crop(frame: &Frame, size: usize) -> Frame {
    let (left, top) = ((frame.width - size) / 2, (frame.height - size) / 2);
    let row = |y: usize| &frame.pixels[(top + y) * frame.width + left..][..size];
    Frame {
        width: size,
        height: size,
        pixels: (0..size).flat_map(row).copied().collect(),
        truth: frame.truth.clone(),
    }
}

fn run<const W: usize, const O: usize, const C: usize>(
    storage: &mut Storage<W, O, C>,
    frame: &Frame,
) -> (Vec<Target>, Summary) {
    let mut detector = Detector::new(ring(), storage);
    let image = Image::new(&frame.pixels, frame.width as u16, frame.height as u16).expect("a frame");
    let mut detection = detector.detect(&image).expect("a frame that fits");
    let targets = detection.by_ref().collect();
    (targets, detection.summary())
}

#[test]
fn wrong_use_is_refused_and_the_next_frame_is_as_if_nothing_had_been() {
    let frame = small_frame();
    let (expected, _) = detect(&frame, TargetSpec::ring(0.5).expect("0.5 is a ratio"));
    let mut storage = Storage::<96, 64, 4000>::new();
    let mut detector = Detector::new(ring(), &mut storage);

    assert_eq!(detector.begin(97, 96).err(), Some(FrameError::Width { given: 97, max: 96 }));
    assert_eq!(detector.begin(0, 96).err(), Some(FrameError::Width { given: 0, max: 96 }));
    assert_eq!(detector.begin(96, 0).err(), Some(FrameError::Height { given: 0 }));
    assert_eq!(detector.begin(96, 20000).err(), Some(FrameError::Height { given: 20000 }));
    let message = FrameError::Width { given: 97, max: 96 }.to_string();
    assert!(message.contains("97") && message.contains("8..=96"), "{message}");

    // A row of the wrong length is ignored; the frame goes on.
    let mut scan = detector.begin(96, 96).expect("fits");
    let mut found = vec![];
    for row in frame.pixels.chunks_exact(96) {
        assert_eq!(scan.push_row(&row[1..]).err(), Some(RowError::Length { given: 95, width: 96 }));
        found.extend(scan.push_row(row).expect("a row"));
    }
    assert_eq!(scan.push_row(&[0; 96]).err(), Some(RowError::TooMany { height: 96 }));
    let mut rest = scan.finish().expect("all rows");
    found.extend(rest.by_ref());
    assert_eq!(found, expected);
    assert_eq!(rest.summary().targets, 1);

    // Half a frame, then a whole one.
    let mut scan = detector.begin(96, 96).expect("fits");
    for row in frame.pixels.chunks_exact(96).take(50) {
        scan.push_row(row).expect("a row");
    }
    assert_eq!(scan.finish().err(), Some(FrameError::TooFewRows { given: 50, height: 96 }));
    let image = Image::new(&frame.pixels, 96, 96).expect("a frame");
    assert_eq!(detector.detect(&image).expect("fits").collect::<Vec<_>>(), expected);
    assert_eq!(
        Image::new(&frame.pixels, 96, 95).err(),
        Some(FrameError::Pixels { given: 96 * 96, width: 96, height: 95 })
    );
}

/// Targets that are not taken from the iterator come with a later row.
#[test]
fn targets_wait_for_who_takes_them() {
    let frame = small_frame();
    let (expected, _) = detect(&frame, TargetSpec::ring(0.5).expect("0.5 is a ratio"));
    let mut storage = Storage::<96, 64, 4000>::new();
    let mut detector = Detector::new(ring(), &mut storage);
    let mut scan = detector.begin(96, 96).expect("fits");
    for row in frame.pixels.chunks_exact(96) {
        scan.push_row(row).expect("a row");
    }
    let mut rest = scan.finish().expect("all rows");
    assert_eq!(rest.by_ref().collect::<Vec<_>>(), expected);
}

/// The same picture elsewhere gives the same target there.
#[test]
fn a_shift_by_whole_pixels_shifts_the_centre() {
    let mut scene = Scene::single(8.0, 40.0, 70.0, [0.1, 0.4]);
    // What is beside the picture has no noise either, and must not change what counts as an edge.
    scene.photometry.noise = 0.0;
    let frame = crop(&scene.render(5), 160);
    let (at_home, _) = detect(&frame, TargetSpec::any());
    for (dx, dy) in [(32, 8), (3, 5), (900, 2), (3777, 611)] {
        let (width, height) = (160 + dx, 160 + dy);
        let mut moved =
            Frame { width, height, pixels: vec![220; width * height], truth: frame.truth.clone() };
        for y in 0..160 {
            moved.pixels[(y + dy) * width + dx..][..160].copy_from_slice(&frame.pixels[y * 160..][..160]);
        }
        let (there, _) = detect(&moved, TargetSpec::any());
        assert_eq!(there.len(), 1);
        let (x, y) = there[0].centre.offset_from(at_home[0].centre);
        assert!((x - dx as f32).abs() < 2e-3 && (y - dy as f32).abs() < 2e-3, "{x} {y} for {dx} {dy}");
        if dx % 32 == 0 && dy % 8 == 0 {
            // The samples of the threshold fall alike, so this is exact.
            assert_eq!((x, y), (dx as f32, dy as f32));
        }
    }
}

/// Runs the frame with every capacity around what it needs, and an ordinary frame after it.
macro_rules! capacities {
    ($frame:expr, $check:expr, $( ($outlines:literal, $crossings:literal) ),* $(,)?) => {
        $( {
            let mut storage = Box::new(Storage::<96, $outlines, $crossings>::new());
            let first = run(&mut storage, $frame);
            assert_eq!(run(&mut storage, $frame), first, "a frame must not depend on the one before");
            $check($outlines, $crossings, &first.0, &first.1);
        } )*
    };
}

#[test]
fn full_buffers_are_counted_and_spoil_nothing_else() {
    let frame = small_frame();
    let (expected, summary) = detect(&frame, TargetSpec::ring(0.5).expect("0.5 is a ratio"));
    assert_eq!(expected.len(), 1);
    let used = summary.used;
    assert_eq!((used.outlines, used.crossings), (NEEDED_OUTLINES, NEEDED_CROSSINGS), "correct the constants");
    let check = |outlines: u16, crossings: u16, targets: &[Target], summary: &Summary| {
        let enough = outlines >= used.outlines && crossings >= used.crossings;
        let dropped = summary.dropped;
        let any = u64::from(dropped.outlines) + u64::from(dropped.crossings) + u64::from(dropped.runs);
        assert_eq!(any == 0, enough, "{outlines} {crossings}: {dropped:?}");
        assert_eq!(targets == expected, enough, "{outlines} {crossings}: {targets:?}");
        assert_eq!(targets.len(), usize::from(enough));
        if outlines < used.outlines {
            assert!(dropped.outlines + dropped.runs > 0);
        } else if crossings < used.crossings {
            assert!(dropped.crossings > 0 && summary.rejected.count(concentric::Reject::BufferFull) > 0);
        }
    };
    const NEEDED_OUTLINES: u16 = 2;
    const NEEDED_CROSSINGS: u16 = 172;
    capacities!(
        &frame,
        check,
        (0, 0),
        (0, 1),
        (1, 0),
        (1, 1),
        (0, 172),
        (1, 172),
        (2, 0),
        (2, 1),
        (2, 171),
        (2, 172),
        (2, 173),
        (3, 172),
        (3, 173),
    );
}

/// A storage for no frame, for the narrowest, and for one pixel less than it is given.
#[test]
fn width_is_a_capacity_like_the_others() {
    let mut none = Storage::<0, 0, 0>::new();
    assert_eq!(
        Detector::new(ring(), &mut none).begin(8, 8).err(),
        Some(FrameError::Width { given: 8, max: 0 })
    );
    let mut narrow = Storage::<32, 4, 4>::new();
    let mut detector = Detector::new(ring(), &mut narrow);
    assert_eq!(detector.begin(7, 8).err(), Some(FrameError::Width { given: 7, max: 32 }));
    assert_eq!(detector.begin(33, 8).err(), Some(FrameError::Width { given: 33, max: 32 }));
    let mut scan = detector.begin(32, 8).expect("fits exactly");
    for _ in 0..8 {
        assert_eq!(scan.push_row(&[200; 32]).expect("a row").count(), 0);
    }
    assert_eq!(scan.finish().expect("all rows").summary().targets, 0);
}

/// Runs that do not fit in a row's list are counted; what lies left of them is found all the same.
#[test]
fn too_many_runs_in_a_row_cost_only_what_lies_right_of_them() {
    let frame = small_frame();
    let width = 96 + 200;
    let mut pixels = vec![220; width * 96];
    for y in 0..96 {
        pixels[y * width..][..96].copy_from_slice(&frame.pixels[y * 96..][..96]);
        // From a row on in which the target is open already.
        for x in (100..width).filter(|_| y >= 48) {
            pixels[y * width + x] = if x % 2 == 0 { 20 } else { 220 };
        }
    }
    let wide = Frame { width, height: 96, pixels, truth: frame.truth.clone() };
    let mut storage = Storage::<320, 8, 4000>::new();
    let (targets, summary) = run(&mut storage, &wide);
    assert!(summary.dropped.runs > 0, "{summary:?}");
    assert_eq!(targets.len(), 1, "{summary:?}");
}

/// Noise, checkerboards, stripes, extremes of size: no panic, nothing found, and the next frame is as ever.
#[test]
fn any_picture_leaves_the_detector_as_it_was() {
    let frame = small_frame();
    let mut storage = Box::new(Storage::<4096, 96, 1500>::new());
    let (expected, _) = run(&mut storage, &frame);
    let mut seed = 1u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 56) as u8
    };
    for (width, height) in [(8, 8), (9, 11), (96, 97), (130, 8), (4096, 9), (8, 500), (323, 241)] {
        for kind in 0..7 {
            let pixels: Vec<u8> = (0..width * height)
                .map(|i| match (kind, i % width, i / width) {
                    (0, ..) => random(),
                    (1, x, y) => {
                        if (x + y) % 2 == 0 {
                            0
                        } else {
                            255
                        }
                    }
                    (2, x, _) => {
                        if x % 3 == 0 {
                            0
                        } else {
                            255
                        }
                    }
                    (3, _, y) => {
                        if y % 2 == 0 {
                            0
                        } else {
                            255
                        }
                    }
                    (4, ..) => 0,
                    (5, ..) => 255,
                    _ => {
                        if random() < 20 {
                            0
                        } else {
                            255
                        }
                    }
                })
                .collect();
            let picture = Frame { width, height, pixels, truth: frame.truth.clone() };
            let (targets, summary) = run(&mut storage, &picture);
            assert!(targets.is_empty(), "{width} x {height}, kind {kind}: {targets:?}");
            assert_eq!((summary.width, summary.height), (width as u16, height as u16));
            assert_eq!(run(&mut storage, &frame).0, expected, "after {width} x {height}, kind {kind}");
        }
    }
}

/// The size that the documentation names, whatever the height of the frame.
#[test]
fn storage_for_sixty_targets_fits_in_51_kib() {
    type Sixty = Storage<1280, 48, 1800>;
    println!("Storage<1280, 48, 1800>: {} bytes", Sixty::BYTES);
    const { assert!(Sixty::BYTES <= 51 * 1024) };
    let mut storage = Box::new(Sixty::new());
    for seed in 0..6 {
        let frame = Scene::many(60, 1280, 1024, true, seed).expect("sixty fit").render(seed);
        let (small, summary) = run(&mut storage, &frame);
        let (large, in_large) = run(&mut Box::<Desktop>::default(), &frame);
        println!("seed {seed}: {:?} of 48, 1800", in_large.used);
        assert_eq!(small.len(), 60, "seed {seed}: {summary:?}");
        assert_eq!(small, large, "seed {seed}");
    }
}
