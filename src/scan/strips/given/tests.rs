//! Frames that come with their runs against the library's own threshold.

extern crate std;

use super::super::super::rows::{KEPT_BLOCKS, Rows};
use super::super::super::runs::{Budget, Transition, TransitionList};
use super::*;
use crate::region::Regions;
use crate::{Detector, Polarity, Region, RowError, Settings, Storage, Summary, Target, TargetSpec};
use std::boxed::Box;
use std::vec;
use std::vec::Vec;
use std::{env, fs, println};

type Desktop = Storage<640, 600, 20000>;

struct Picture {
    width: usize,
    pixels: Vec<u8>,
}

/// A row's runs, and the least contrast when they were found.
type Given = (Vec<Run>, u8);

fn random(seed: &mut u32, most: u32) -> u32 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*seed >> 8) % (most + 1)
}

/// Rings of many sizes under uneven light, with noise.
fn rendered(seed: u32, noise: u32) -> Picture {
    let (width, height) = (640, 480);
    let mut state = seed;
    let rings: Vec<(f32, f32, f32)> = (0..12)
        .map(|i| {
            let shift = |state: &mut u32| random(state, 160) as f32 / 8.0;
            let (x, y) = (80.0 + 160.0 * (i % 4) as f32, 80.0 + 160.0 * (i / 4) as f32);
            (x + shift(&mut state), y + shift(&mut state), 8.0 + 2.5 * shift(&mut state))
        })
        .collect();
    let mut level = |i: usize| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        let dark = rings.iter().map(|&(cx, cy, r)| {
            let (dx, dy) = (x - cx, 1.3 * (y - cy));
            let distance = crate::math::sqrt(dx * dx + dy * dy);
            let edge = |radius: f32| (radius - distance + 0.5).clamp(0.0, 1.0);
            edge(r) - edge(0.5 * r)
        });
        let light = (120.0 + 0.15 * x) * (1.0 - 0.8 * dark.fold(0.0, f32::max));
        (light + random(&mut state, noise) as f32) as u8
    };
    Picture { width, pixels: (0..width * height).map(&mut level).collect() }
}

/// A photograph, if there is a folder of them.
fn photograph() -> Option<Picture> {
    let Some(folder) = env::var_os("CONCENTRIC_PHOTOS") else {
        println!("photograph skipped: set CONCENTRIC_PHOTOS to their folder");
        return None;
    };
    let file = fs::read(std::path::Path::new(&folder).join("openmv-apriltags.pgm")).unwrap();
    // Its header ends somewhere before the pixels.
    Some(Picture { width: 640, pixels: file[file.len() - 640 * 426..].to_vec() })
}

/// The runs that the library finds itself.
fn own_runs(picture: &Picture) -> Vec<Given> {
    let (width, height) = (picture.width, picture.pixels.len() / picture.width);
    let (mut kept, mut data) = (vec![0; KEPT_BLOCKS * width], vec![0; width / 2]);
    let mut found = vec![Transition::ZERO; width];
    let (mut rows, mut strips) = (Rows::new(&mut kept), Strips::new(&mut data));
    let mut list = TransitionList::new(&mut found);
    rows.begin(width as u16, height as u16);
    strips.begin(width as u16, Polarity::Dark);
    let (mut runs, mut contrasts, mut budget) = (vec![], vec![], Budget::NONE);
    let mut block = |rows: &Rows<'_>| {
        strips.measure(rows, &mut Regions::all());
        contrasts.push(strips.min_contrast());
        if strips.blocks() < 2 {
            return;
        }
        strips.resolve(rows, &mut budget);
        for row in 0..BLOCK_ROWS {
            assert_eq!(list.fill(&strips, row, width as u16, &mut budget), 0);
            let ends: Vec<u16> = list.as_slice().iter().map(|transition| transition.x).collect();
            runs.push(ends.chunks(2).map(|ends| Run { start: ends[0], end: ends[1] }).collect());
        }
    };
    for row in picture.pixels.chunks(width) {
        rows.push(row);
        if rows.block_complete() {
            block(&rows);
        }
    }
    // Below the frame, until every row has its runs.
    for _ in height / BLOCK_ROWS..height.div_ceil(BLOCK_ROWS) + 1 {
        block(&rows);
    }
    runs.truncate(height);
    runs.into_iter().enumerate().map(|(y, runs)| (runs, contrasts[y / BLOCK_ROWS])).collect()
}

fn begin<'d, 's>(detector: &'d mut Detector<'s>, picture: &Picture) -> crate::Scan<'d, 's> {
    let height = picture.pixels.len() / picture.width;
    detector.begin(picture.width as u16, height as u16).unwrap()
}

fn with_own(detector: &mut Detector<'_>, picture: &Picture) -> (Vec<Target>, Summary) {
    let mut scan = begin(detector, picture);
    let mut targets = vec![];
    for row in picture.pixels.chunks(picture.width) {
        targets.extend(scan.push_row(row).unwrap());
    }
    let mut rest = scan.finish().unwrap();
    targets.extend(rest.by_ref());
    (targets, rest.summary())
}

fn with_runs(detector: &mut Detector<'_>, picture: &Picture, given: &[Given]) -> (Vec<Target>, Summary) {
    let mut scan = begin(detector, picture);
    let mut targets = vec![];
    for (row, (runs, contrast)) in picture.pixels.chunks(picture.width).zip(given) {
        targets.extend(scan.push_row_with_runs(row, runs, *contrast).unwrap());
    }
    let mut rest = scan.finish().unwrap();
    targets.extend(rest.by_ref());
    (targets, rest.summary())
}

fn settings() -> Settings {
    Settings::new(TargetSpec::any())
}

#[test]
fn the_librarys_own_runs_give_its_own_results() {
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let mut pictures: Vec<Picture> =
        [(1, 0), (2, 4), (3, 12), (4, 30)].map(|(seed, noise)| rendered(seed, noise)).into();
    // A height that is no multiple of a block's.
    pictures[1].pixels.truncate(640 * 477);
    pictures.extend(photograph());
    let mut all = 0;
    for picture in &pictures {
        let expected = with_own(&mut detector, picture);
        let given = own_runs(picture);
        assert_eq!(with_runs(&mut detector, picture, &given), expected);
        all += expected.0.len();
        // The perturbation: every run a little longer.
        let mut altered = given;
        for run in altered.iter_mut().flat_map(|(runs, _)| runs) {
            run.start = run.start.saturating_sub(1);
        }
        if expected.0.len() > 3 && altered.iter().all(|(runs, _)| Strips::check(runs, 640).is_ok()) {
            assert_ne!(with_runs(&mut detector, picture, &altered).0, expected.0);
        }
    }
    assert!(all >= 40, "{all}");
}

#[test]
fn wrong_runs_are_refused_and_the_frame_goes_on() {
    let picture = rendered(5, 3);
    let given = own_runs(&picture);
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let expected = with_own(&mut detector, &picture).0;
    let run = |start, end| Run { start, end };
    let wrong: [(usize, &[Run]); 6] = [
        (0, &[run(5, 5)]),
        (0, &[run(9, 5)]),
        (0, &[run(600, 641)]),
        (1, &[run(5, 9), run(9, 12)]),
        (1, &[run(50, 90), run(20, 30)]),
        (2, &[run(5, 9), run(10, 14), run(12, 20)]),
    ];
    let mut scan = begin(&mut detector, &picture);
    let mut targets = vec![];
    for (row, (runs, contrast)) in picture.pixels.chunks(640).zip(&given) {
        for (at, wrong) in wrong {
            let refused = scan.push_row_with_runs(row, wrong, *contrast).err();
            assert_eq!(refused, Some(RowError::Run { at }));
        }
        assert_eq!(
            scan.push_row_with_runs(&row[1..], runs, *contrast).err(),
            Some(RowError::Length { given: 639, width: 640 })
        );
        targets.extend(scan.push_row_with_runs(row, runs, *contrast).unwrap());
        let is_last = row.as_ptr_range().end == picture.pixels.as_ptr_range().end;
        let refused = if is_last { RowError::TooMany { height: 480 } } else { RowError::Mixed };
        assert_eq!(scan.push_row(row).err(), Some(refused));
    }
    assert_eq!(scan.push_row_with_runs(&[0; 640], &[], 10).err(), Some(RowError::TooMany { height: 480 }));
    targets.extend(scan.finish().unwrap());
    assert_eq!(targets, expected);
    let row = &picture.pixels[..640];
    let mut scan = begin(&mut detector, &picture);
    scan.push_row(row).unwrap();
    assert_eq!(scan.push_row_with_runs(row, &[], 10).err(), Some(RowError::Mixed));
    let regions = [Region { top: 0, bottom: 9, left: 0, right: 9 }];
    let mut scan = begin(&mut detector, &picture).within(&regions).unwrap();
    assert_eq!(scan.push_row_with_runs(row, &[], 10).err(), Some(RowError::Mixed));
}

/// Any runs beside any pixels: nothing panics, and the next frame is as ever.
#[test]
fn any_runs_leave_the_detector_as_it_was() {
    let good = rendered(6, 3);
    let mut storage = Box::<Desktop>::default();
    let mut detector = Detector::new(settings(), &mut storage);
    let expected = with_own(&mut detector, &good);
    let (mut seed, mut taken) = (9, 0);
    for round in 0..120 {
        let (width, height) = [(640, 40), (33, 31), (8, 8), (320, 101)][round % 4];
        let mut scan = detector.begin(width, height).unwrap();
        loop {
            let row: Vec<u8> = (0..width).map(|x| (x * 7) as u8 ^ random(&mut seed, 255) as u8).collect();
            let longest = [3, 40, u32::from(width), 70_000][round / 4 % 4];
            let mut x = 0;
            let runs: Vec<Run> = (0..random(&mut seed, 60))
                .map(|_| {
                    let start = x + random(&mut seed, longest);
                    x = start + random(&mut seed, longest);
                    Run { start: start as u16, end: x as u16 }
                })
                .collect();
            let right = runs.partition_point(|run| run.end <= width).min(runs.len());
            let contrast = random(&mut seed, 255) as u8;
            let took = scan.push_row_with_runs(&row, &runs, contrast).is_ok();
            let took = took || scan.push_row_with_runs(&row, &runs[..right], contrast).is_ok();
            taken += usize::from(took && right > 0);
            let next = if took { Ok(0) } else { scan.push_row_with_runs(&row, &[], contrast).map(|_| 0) };
            if next == Err(RowError::TooMany { height }) {
                break;
            }
        }
        scan.finish().unwrap().summary();
    }
    assert!(taken > 500, "{taken}");
    assert_eq!(with_own(&mut detector, &good), expected);
}
