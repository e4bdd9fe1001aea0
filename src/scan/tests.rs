//! Outlines against a slow, obvious model: flood fill.

extern crate std;

use super::{Crossing, KEPT_BLOCKS, Outline, Scanner, Transition};
use crate::region::Regions;
use crate::settings::{Settings, TargetSpec};
use crate::storage::Buffers;
use std::collections::{BTreeMap, BTreeSet};
use std::vec;
use std::vec::Vec;

/// What both sides say of an outline: dark inside?, left, right, top, bottom, then area and moments of the filled shape.
type Account = (bool, [u16; 4], [i64; 6]);

/// A picture of black and white blocks of 8 x 8 px, so that the local threshold cannot but separate them.
struct Blocks {
    width: usize,
    height: usize,
    dark: Vec<bool>,
}

const BLOCK: usize = 8;

impl Blocks {
    fn random(width: usize, height: usize, share: u32, seed: &mut u32) -> Self {
        let mut next = || {
            *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (*seed >> 16) % 100
        };
        // Light all around, so that no outline is cut.
        let dark = (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                let border = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
                next() < share && !border
            })
            .collect();
        Self { width, height, dark }
    }

    fn pixels(&self) -> (usize, usize, Vec<u8>) {
        let (w, h) = (self.width * BLOCK, self.height * BLOCK);
        let level = |i: usize| if self.dark[i / w / BLOCK * self.width + i % w / BLOCK] { 20 } else { 220 };
        (w, h, (0..w * h).map(level).collect())
    }

    /// Connected blocks: dark ones also over corners.
    fn regions(&self) -> Vec<BTreeSet<(i32, i32)>> {
        let (w, h) = (self.width as i32, self.height as i32);
        let is_dark = |x: i32, y: i32| self.dark[(y * w + x) as usize];
        let mut seen = BTreeSet::new();
        let mut regions = vec![];
        for start in (0..w * h).map(|i| (i % w, i / w)) {
            if !seen.insert(start) {
                continue;
            }
            let dark = is_dark(start.0, start.1);
            let (mut region, mut open) = (BTreeSet::from([start]), vec![start]);
            while let Some((x, y)) = open.pop() {
                for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                    let next = (x + dx, y + dy);
                    let inside = (0..w).contains(&next.0) && (0..h).contains(&next.1);
                    let joined = dark || dx == 0 || dy == 0;
                    if inside && joined && is_dark(next.0, next.1) == dark && seen.insert(next) {
                        region.insert(next);
                        open.push(next);
                    }
                }
            }
            regions.push(region);
        }
        regions
    }

    /// Blocks that cannot be reached from outside without passing the region.
    fn filled(&self, region: &BTreeSet<(i32, i32)>, dark: bool) -> BTreeSet<(i32, i32)> {
        let (w, h) = (self.width as i32, self.height as i32);
        let mut outside = BTreeSet::from([(-1, -1)]);
        let mut open = vec![(-1, -1)];
        while let Some((x, y)) = open.pop() {
            for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                let next = (x + dx, y + dy);
                let near = (-1..=w).contains(&next.0) && (-1..=h).contains(&next.1);
                // What passes between two blocks that touch at a corner is light around dark ones only if they are not joined.
                let joined = !dark || dx == 0 || dy == 0;
                if near && joined && !region.contains(&next) && outside.insert(next) {
                    open.push(next);
                }
            }
        }
        (0..w * h).map(|i| (i % w, i / w)).filter(|p| !outside.contains(p)).collect()
    }

    fn accounts(&self) -> Vec<Account> {
        let mut accounts = vec![];
        for region in self.regions() {
            let &(x, y) = region.first().unwrap();
            let dark = self.dark[(y * self.width as i32 + x) as usize];
            if !dark && region.contains(&(0, 0)) {
                continue;
            }
            accounts.push(account(dark, &self.filled(&region, dark)));
        }
        accounts.sort();
        accounts
    }
}

fn account(dark: bool, blocks: &BTreeSet<(i32, i32)>) -> Account {
    let sign = if dark { 1 } else { -1 };
    let (mut bounds, mut sums) = ([u16::MAX, 0, u16::MAX, 0], [0i64; 6]);
    for &(bx, by) in blocks {
        for (x, y) in
            (0..BLOCK * BLOCK).map(|i| (bx as usize * BLOCK + i % BLOCK, by as usize * BLOCK + i / BLOCK))
        {
            let (x16, y16) = (x as u16, y as u16);
            bounds = [bounds[0].min(x16), bounds[1].max(x16 + 1), bounds[2].min(y16), bounds[3].max(y16)];
            let (x, y) = (x as i64, y as i64);
            for (sum, term) in sums.iter_mut().zip([1, x, y, x * x, x * y, y * y]) {
                *sum += sign * term;
            }
        }
    }
    (dark, bounds, sums)
}

/// Buffers for any frame of these tests.
struct Memory {
    rows: Vec<u32>,
    strips: Vec<u32>,
    previous: Vec<Transition>,
    current: Vec<Transition>,
    outlines: Vec<Outline>,
    crossings: Vec<Crossing>,
}

impl Memory {
    fn new(width: usize) -> Self {
        Self {
            rows: vec![0; width * KEPT_BLOCKS],
            strips: vec![0; width],
            previous: vec![Transition::ZERO; width + 2],
            current: vec![Transition::ZERO; width + 2],
            outlines: vec![Outline::ZERO; 4000],
            crossings: vec![Crossing::ZERO; 60000],
        }
    }

    fn scanner(&mut self) -> Scanner<'_> {
        Scanner::new(Buffers {
            rows: &mut self.rows,
            strips: &mut self.strips,
            previous: &mut self.previous,
            current: &mut self.current,
            outlines: &mut self.outlines,
            crossings: &mut self.crossings,
        })
    }
}

fn scanned(scanner: &mut Scanner<'_>, (width, height, pixels): &(usize, usize, Vec<u8>)) -> Vec<Account> {
    let mut accounts = vec![];
    let mut take = |scanner: &mut Scanner<'_>| {
        while let Some(label) = scanner.outlines.take_closed() {
            let outline = scanner.outlines.get_mut(label).unwrap();
            assert!(!outline.cut && !outline.lossy);
            let m = outline.moments;
            let bounds = [outline.left, outline.right, outline.top, outline.bottom];
            accounts.push((m.area > 0, bounds, [m.area, m.x, m.y, m.xx, m.xy, m.yy]));
            scanner.pool.free(&mut outline.crossings);
            scanner.outlines.free(label);
        }
    };
    scanner.begin(*width as u16, *height as u16, &Settings::new(TargetSpec::any()).px_per_run(0));
    for row in pixels.chunks_exact(*width) {
        scanner.push_row(row, &mut Regions::all());
        take(scanner);
    }
    scanner.finish(&mut Regions::all());
    take(scanner);
    accounts.sort();
    accounts
}

#[test]
fn outlines_are_those_of_a_flood_fill() {
    let mut seed = 7;
    let mut polarities = BTreeMap::new();
    for (width, height) in [(3, 3), (8, 6), (13, 9), (24, 24), (33, 17)] {
        for share in [10, 35, 50, 65, 90] {
            let blocks = Blocks::random(width, height, share, &mut seed);
            let picture = blocks.pixels();
            let mut memory = Memory::new(picture.0.next_multiple_of(32));
            let mut scanner = memory.scanner();
            let expected = blocks.accounts();
            for (dark, ..) in &expected {
                *polarities.entry(*dark).or_insert(0) += 1;
            }
            assert_eq!(scanned(&mut scanner, &picture), expected, "{width} x {height}, {share} %");
            // Everything was given back: the same frame again finds the same.
            assert_eq!(scanned(&mut scanner, &picture), expected);
        }
    }
    assert!(polarities[&true] > 50 && polarities[&false] > 50, "{polarities:?}");
}

#[test]
fn moments_of_the_largest_disc_in_the_far_corner_are_exact() {
    let (width, height) = (4096usize, 4096usize);
    let inside = |x: i64, y: i64| (x - 3085) * (x - 3085) + (y - 3085) * (y - 3085) <= 1000 * 1000;
    let mut memory = Memory::new(width);
    let mut scanner = memory.scanner();
    scanner.begin(width as u16, height as u16, &Settings::new(TargetSpec::any()).px_per_run(0));
    let mut expected = [0i64; 6];
    for y in 0..height as i64 {
        let row: Vec<u8> = (0..width as i64).map(|x| if inside(x, y) { 30 } else { 200 }).collect();
        for x in (0..width as i64).filter(|&x| inside(x, y)) {
            for (sum, term) in expected.iter_mut().zip([1, x, y, x * x, x * y, y * y]) {
                *sum += term;
            }
        }
        scanner.push_row(&row, &mut Regions::all());
    }
    scanner.finish(&mut Regions::all());
    let label = scanner.outlines.take_closed().unwrap();
    let m = scanner.outlines.get(label).unwrap().moments;
    assert_eq!([m.area, m.x, m.y, m.xx, m.xy, m.yy], expected);
    assert!(expected[3] > i64::from(u32::MAX), "no test of 32-bit overflow");
}

/// An outline must be known before the one around it, also when both close within a block of rows.
#[test]
fn closed_outlines_come_in_the_order_of_their_closing() {
    let (width, height) = (32usize, 32usize);
    let within = |v: usize, first: usize, end: usize| (first..end).contains(&v);
    let level = |i: usize| {
        let (x, y) = (i % width, i / width);
        let dark = within(x, 8, 24) && within(y, 8, 23) && !(within(x, 10, 22) && within(y, 10, 22));
        if dark { 20 } else { 220 }
    };
    let pixels = (0..width * height).map(level).collect();
    let mut memory = Memory::new(width);
    let mut scanner = memory.scanner();
    scanner.begin(width as u16, height as u16, &Settings::new(TargetSpec::any()).px_per_run(0));
    let mut bottoms = vec![];
    let rows: Vec<u8> = pixels;
    for row in rows.chunks_exact(width) {
        scanner.push_row(row, &mut Regions::all());
        while let Some(label) = scanner.outlines.take_closed() {
            bottoms.push(scanner.outlines.get(label).unwrap().bottom);
        }
    }
    assert_eq!(bottoms, [21, 22]);
}
