//! The noise figure, and dark pixels against the picture.

extern crate std;
use super::super::rows::KEPT_BLOCKS;
use super::*;
use crate::region::Regions;
use std::vec;

/// About Gaussian, from the sum of twelve.
fn noise(seed: &mut u32) -> f32 {
    let mut uniform = || {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*seed >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    (0..12).map(|_| uniform()).sum()
}

/// Calls `check` for each resolved block with its first row.
fn scan(
    width: usize,
    height: usize,
    targets: Polarity,
    level: impl Fn(usize, usize) -> u8,
    mut check: impl FnMut(&Strips<'_>, usize),
) {
    let (mut kept, mut data) = (vec![0; KEPT_BLOCKS * width], vec![0; width]);
    let (mut rows, mut strips) = (Rows::new(&mut kept), Strips::new(&mut data));
    rows.begin(width as u16, height as u16);
    strips.begin(width as u16, targets);
    for y in 0..height {
        rows.push(&(0..width).map(|x| level(x, y)).collect::<vec::Vec<_>>());
        if rows.block_complete() {
            strips.measure(&rows, &mut Regions::all());
            if y > 4 {
                let mut budget = Budget::NONE;
                strips.resolve(&rows, &mut budget);
                check(&strips, y - 7);
            }
        }
    }
}

#[test]
fn the_least_contrast_is_ten_sigmas_of_the_noise() {
    for sigma in [0.0f32, 1.5, 2.0, 3.0, 5.0, 8.0] {
        let mut seed = 5;
        let pixels: vec::Vec<u8> =
            (0..320 * 200).map(|_| (150.0 + sigma * noise(&mut seed)).round() as u8).collect();
        let mut last = 0;
        scan(
            320,
            200,
            Polarity::Dark,
            |x, y| pixels[320 * y + x],
            |strips, _| {
                last = strips.min_contrast();
            },
        );
        let expected = (10.4 * sigma).max(10.0);
        assert!((f32::from(last) - expected).abs() <= 0.15 * expected, "sigma {sigma}: {last}");
    }
}

/// A disc of every size in every place is dark where it is, to the blur of a pixel, and nothing else is.
/// The paper may be dark as well: a frame begins as the paper.
#[test]
fn pixels_are_dark_where_the_picture_is() {
    for (cx, cy, radius) in
        [(40.3, 30.1, 4.5f32), (63.9, 35.7, 5.0), (65.2, 33.0, 12.0), (80.0, 50.0, 33.3), (95.5, 61.0, 45.0)]
    {
        for (targets, contrast) in [(Polarity::Dark, 80.0), (Polarity::Light, -80.0)] {
            let reach = |x: usize, y: usize| (x as f32 - cx).hypot(y as f32 - cy) - radius;
            let level = |x: usize, y: usize| (120.0 + contrast * reach(x, y).clamp(-1.0, 1.0)) as u8;
            let mut inside = 0;
            scan(192, 128, targets, level, |strips, first| {
                each_pixel(strips, 192, |x, row, is_dark| {
                    let (reach, is_inside) = (reach(x, first + row), is_dark == (targets == Polarity::Dark));
                    inside += u32::from(is_inside);
                    assert!(
                        reach.abs() < 1.0 || is_inside == (reach < 0.0),
                        "{targets:?} {x} {}",
                        first + row
                    );
                });
            });
            assert!((inside as f32 / (core::f32::consts::PI * radius * radius) - 1.0).abs() < 0.1);
        }
    }
}

/// Calls `look` for each pixel of the block in work: column, row of the block, and whether it is dark.
fn each_pixel(strips: &Strips<'_>, width: usize, mut look: impl FnMut(usize, usize, bool)) {
    for row in 0..BLOCK_ROWS {
        let mut side = 0;
        let mut of_interest = strips.dark(row).peekable();
        for x in (0..width).step_by(STRIP) {
            let dark = of_interest.next_if(|(at, _)| usize::from(*at) == x);
            let dark = dark.map_or(side, |(_, dark)| dark);
            side = if dark >> 31 != 0 { !0 } else { 0 };
            (0..STRIP).for_each(|i| look(x + i, row, dark >> i & 1 != 0));
        }
    }
}

/// Flat surroundings at whose level a threshold is left, as noise in uneven light leaves it, are paper; what is clearly beyond it
/// keeps its side.
#[test]
fn what_is_at_the_threshold_is_paper() {
    let about = [100 * kernel::ONES, 104 * kernel::ONES];
    for (held, sides) in
        [(97, [false, false]), (99, [false, true]), (105, [false, true]), (107, [true, true])]
    {
        let is_dark = [Polarity::Dark, Polarity::Light].map(|targets| {
            let thresholds = threshold::thresholds(held * kernel::ONES, about, 16, targets).to_le_bytes();
            assert!(
                thresholds
                    .iter()
                    .all(|&threshold| threshold == thresholds[0] && !(92..=112).contains(&threshold))
            );
            thresholds[0] > 104
        });
        assert_eq!(is_dark, sides, "{held}");
    }
}
