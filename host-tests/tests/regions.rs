//! Frames of which only regions are searched.

mod common;

use common::{Desktop, detect};
use concentric::track::Tracker;
use concentric::{Detector, FrameError, Observer, Region, RowError, Scan, Settings, Target, TargetSpec};
use concentric_host::render::{Frame, Scene};

/// Columns and rows of what surrounds a target that its measurement looks at.
const AROUND: [f32; 2] = [24.0, 12.0];

fn settings() -> Settings {
    Settings::new(TargetSpec::any())
}

/// The targets of a frame, and how many of its rows were skipped.
fn search(detector: &mut Detector<'_>, frame: &Frame, regions: Option<&[Region]>) -> (Vec<Target>, usize) {
    let mut scan = detector.begin(frame.width as u16, frame.height as u16).expect("fits");
    if let Some(regions) = regions {
        scan = scan.within(regions).expect("regions of the frame");
    }
    run(scan, frame)
}

fn run<O: Observer>(mut scan: Scan<'_, '_, O>, frame: &Frame) -> (Vec<Target>, usize) {
    let (mut targets, mut skipped) = (vec![], 0);
    for row in frame.pixels.chunks_exact(frame.width) {
        if scan.needs_row() {
            targets.extend(scan.push_row(row).expect("a row"));
        } else {
            skipped += 1;
            targets.extend(scan.skip_row().expect("a row that nobody needs"));
        }
    }
    targets.extend(scan.finish().expect("all rows"));
    (targets, skipped)
}

/// The box of a target and `margin` px around it, as far as it lies in the frame.
fn around(target: &Target, margin: [f32; 2], frame: &Frame) -> Region {
    let (x, y) = target.circles[0].ellipse.centre.to_px();
    let span = |centre: f32, size: usize, margin: f32| {
        let reach = target.circles[0].ellipse.a + margin;
        ((centre - reach).max(0.0) as u16, ((centre + reach) as u16).min(size as u16 - 1))
    };
    let ((left, right), (top, bottom)) = (span(x, frame.width, margin[0]), span(y, frame.height, margin[1]));
    Region { top, bottom, left, right }
}

/// Whether both are the same target, the places apart by less than a quarter of their standard deviation.
fn is_near(a: &Target, b: &Target) -> bool {
    let (x, y) = a.centre.offset_from(b.centre);
    let (vx, vy) = (b.covariance.xx, b.covariance.yy);
    a.circles.len() == b.circles.len() && x * x < 0.0625 * vx && y * y < 0.0625 * vy
}

/// Scenes, and whether they are without noise.
fn scenes() -> Vec<(Frame, bool)> {
    let mut frames = vec![];
    for seed in 0..8 {
        for (count, width, height) in [(3, 640, 480), (12, 640, 480), (30, 1280, 1024)] {
            let mut scene = Scene::many(count, width, height, seed % 2 == 1, seed).expect("they fit");
            scene.photometry.noise = 0.5 * (seed % 3) as f64;
            frames.push((scene.render(seed), seed % 3 == 0));
        }
    }
    frames
}

#[test]
fn a_target_in_its_region_is_measured_as_in_the_whole_frame() {
    measured_in_regions(TargetSpec::any(), scenes());
}

/// On dark paper too, of which nothing outside the regions is known.
#[test]
fn a_light_target_in_its_region_is_measured_as_in_the_whole_frame() {
    let mut negatives = scenes();
    let pixels = negatives.iter_mut().flat_map(|(frame, _)| &mut frame.pixels);
    pixels.for_each(|pixel| *pixel = 255 - *pixel);
    measured_in_regions(TargetSpec::any().light(), negatives);
}

fn measured_in_regions(spec: TargetSpec, scenes: Vec<(Frame, bool)>) {
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(Settings::new(spec), &mut storage);
    let (mut all, mut same, mut skipped) = (0, 0, 0);
    for (frame, is_clean) in scenes {
        let (whole, none) = search(&mut detector, &frame, None);
        assert_eq!(none, 0);
        let mut regions: Vec<_> = whole.iter().map(|target| around(target, AROUND, &frame)).collect();
        regions.sort_by_key(|region| region.top);
        let (within, rows) = search(&mut detector, &frame, Some(&regions));
        skipped += rows;
        let mut check = |found: &[Target], target: &Target| {
            let near = found.iter().find(|found| is_near(found, target));
            assert!(near.is_some(), "{target:?}\n{found:?}");
            let is_same = near == Some(target);
            assert!(is_same || !is_clean, "{target:?}\n{near:?}");
            (all, same) = (all + 1, same + usize::from(is_same));
        };
        whole.iter().for_each(|target| check(&within, target));
        // Some of them alone.
        for target in whole.iter().take(4) {
            let (found, rows) = search(&mut detector, &frame, Some(&[around(target, AROUND, &frame)]));
            check(&found, target);
            assert!(rows > 0);
        }
    }
    println!("{same} of {all} targets the same, {skipped} rows skipped");
    assert!(same * 10 > all * 9, "{same} of {all}");
    assert!(all > 300, "{all}");
    assert!(skipped > 1000, "{skipped}");
}

/// The perturbation of the above: with less around them targets are lost, or measured otherwise.
#[test]
fn a_region_that_cuts_a_target_loses_it() {
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let mut lost = 0;
    let frames = scenes();
    for (frame, _) in &frames {
        let (whole, _) = search(&mut detector, frame, None);
        for target in whole.iter().take(2) {
            let less = -0.5 * target.circles[0].ellipse.a;
            let region = around(target, [less; 2], frame);
            let (found, _) = search(&mut detector, frame, Some(&[region]));
            lost += usize::from(!found.contains(target));
        }
    }
    assert!(lost > frames.len(), "{lost} of {}", 2 * frames.len());
}

/// What is outside of the rows that are needed is not looked at, whatever was there in the frame before.
#[test]
fn nothing_outside_matters() {
    let mut scene = Scene::many(3, 640, 480, true, 3).expect("three fit");
    scene.photometry.noise = 1.0;
    let frame = scene.render(3);
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let (whole, _) = search(&mut detector, &frame, None);
    for target in &whole {
        let region = [around(target, AROUND, &frame)];
        let (expected, _) = search(&mut detector, &frame, Some(&region));
        let mut scan = detector.begin(640, 480).expect("fits").within(&region).expect("within");
        let mut found = vec![];
        for (y, row) in frame.pixels.chunks_exact(640).enumerate() {
            let needed = scan.needs_row();
            let other: Vec<u8> = (0..640).map(|x| (x * 37 + y * 101) as u8).collect();
            found.extend(scan.push_row(if needed { row } else { &other }).expect("a row"));
        }
        found.extend(scan.finish().expect("all rows"));
        assert_eq!(found, expected);
    }
    // No region, no target; and the whole frame afterwards is as ever.
    assert_eq!(search(&mut detector, &frame, Some(&[])), (vec![], 480));
    assert_eq!(search(&mut detector, &frame, None).0, whole);
    assert_eq!(detect(&frame, TargetSpec::any()).0, whole);
}

#[test]
fn wrong_regions_are_refused() {
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let good = Region { top: 8, bottom: 20, left: 0, right: 63 };
    let wrong = [
        Region { bottom: 48, ..good },
        Region { right: 64, ..good },
        Region { top: 21, ..good },
        Region { left: 64, ..good },
        Region { top: 7, ..good },
    ];
    for region in wrong {
        let refused = detector.begin(64, 48).expect("fits").within(&[good, region]).err();
        assert_eq!(refused, Some(FrameError::Region { at: 1 }), "{region:?}");
    }
    let regions = [Region { top: 24, ..good }; 1];
    let regions = [Region { bottom: 30, ..regions[0] }];
    let mut scan = detector.begin(64, 48).expect("fits").within(&regions).expect("good");
    assert!(!scan.needs_row());
    scan.skip_row().expect("nobody needs it");
    assert_eq!(scan.within(&regions).err(), Some(FrameError::LateRegions { given: 1 }));
    let regions = [good];
    let mut scan = detector.begin(64, 48).expect("fits").within(&regions).expect("good");
    assert_eq!(scan.skip_row().err(), Some(RowError::Needed { row: 0 }));
    for row in 0..48 {
        // Blocks of four rows, two more on either side of those that the region touches and one in which it ends.
        assert_eq!(scan.needs_row(), row < 32, "row {row}");
        scan.push_row(&[200; 64]).expect("a row");
    }
    assert_eq!(scan.skip_row().err(), Some(RowError::TooMany { height: 48 }));
}

/// Any regions over any picture: nothing panics, and the next frame is as ever.
#[test]
fn any_regions_leave_the_detector_as_it_was() {
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let scene = Scene::many(6, 320, 240, true, 1).expect("six fit");
    let frame = scene.render(1);
    let (expected, _) = search(&mut detector, &frame, None);
    let mut state = 1u32;
    let mut random = move |most: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 8) % (most + 1)) as u16
    };
    for round in 0..200u16 {
        let (width, height) = [(320, 240), (319, 237), (40, 9), (33, 240)][usize::from(round % 4)];
        let pixels = (0..usize::from(width) * usize::from(height))
            .map(|i| match round % 3 {
                0 => random(255) as u8,
                1 if i / 3 % 2 == 0 => 20,
                1 => 220,
                _ => frame.pixels[i],
            })
            .collect();
        let picture =
            Frame { width: width.into(), height: height.into(), pixels, truth: frame.truth.clone() };
        let mut regions: Vec<_> = (0..random(6))
            .map(|_| {
                let (top, left) = (random(u32::from(height) - 1), random(u32::from(width) - 1));
                let bottom = top + random(u32::from(height - 1 - top));
                Region { top, bottom, left, right: left + random(u32::from(width - 1 - left)) }
            })
            .collect();
        regions.sort_by_key(|region| region.top);
        let first = search(&mut detector, &picture, Some(&regions));
        assert_eq!(search(&mut detector, &picture, Some(&regions)), first, "{regions:?}");
        if round % 20 == 0 {
            assert_eq!(search(&mut detector, &frame, None).0, expected);
        }
    }
}

/// Moves the targets of a scene.
fn moved(scene: &Scene, by: impl Fn(usize) -> (f64, f64)) -> Frame {
    let mut scene = scene.clone();
    for (i, target) in scene.targets.iter_mut().enumerate() {
        let (dx, dy) = by(i);
        target.pose.x += dx;
        target.pose.y += dy;
    }
    scene.render(7)
}

#[test]
fn tracked_targets_keep_their_ids_and_their_places() {
    let mut scene = Scene::many(5, 640, 480, false, 2).expect("five fit");
    scene.photometry.noise = 1.0;
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let mut tracker = Tracker::<16>::new().whole_every(5);
    let (mut whole_frames, mut skipped) = (0, 0);
    for number in 0..12 {
        let speed = |i: usize| [(3.0, 1.0), (-2.0, 2.5), (0.0, -3.0)][i % 3];
        let frame = moved(&scene, |i| (speed(i).0 * f64::from(number), speed(i).1 * f64::from(number)));
        tracker.begin();
        let regions = tracker.regions(640, 480);
        whole_frames += usize::from(regions.is_none());
        let (found, rows) = search(&mut detector, &frame, regions.as_deref());
        skipped += rows;
        let mut ages: Vec<_> = found.iter().map(|t| tracker.follow(t).expect("room")).collect();
        ages.sort_by_key(|track| track.id);
        let ages: Vec<_> = ages.iter().map(|track| (track.id, track.age)).collect();
        assert_eq!(ages, (1..=5).map(|id| (id, number as u32)).collect::<Vec<_>>());
        let whole = detect(&frame, TargetSpec::any()).0;
        assert_eq!(found.len(), whole.len());
        for target in &whole {
            assert!(found.iter().any(|found| is_near(found, target)), "frame {number}: {target:?}");
        }
    }
    assert_eq!((whole_frames, tracker.found_again()), (3, 0));
    println!("{skipped} rows skipped");
}

/// A target that jumps is missing until the next whole frame, and is then the same if it is near enough.
#[test]
fn a_target_that_leaves_its_region_is_found_by_the_next_whole_frame() {
    let mut scene = Scene::many(3, 640, 480, false, 2).expect("three fit");
    scene.photometry.noise = 1.0;
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let mut tracker = Tracker::<16>::new().whole_every(4);
    let mut found = vec![];
    for number in 0..9 {
        // From the second frame on far from where it is expected.
        let frame = moved(&scene, |i| if i == 0 && number > 0 { (-70.0, 40.0) } else { (0.0, 0.0) });
        tracker.begin();
        let regions = tracker.regions(640, 480);
        let (targets, _) = search(&mut detector, &frame, regions.as_deref());
        targets.iter().for_each(|target| assert!(tracker.follow(target).is_some()));
        found.push(targets.len());
    }
    // Its region grows while it is missing; at the latest the whole frame has it.
    assert_eq!((found[0], found[1]), (3, 2), "{found:?}");
    assert!(found[4..].iter().all(|&count| count == 3), "{found:?}");
}
