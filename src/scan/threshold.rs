//! The local threshold, from the rows themselves.
//!
//! The frame is divided into cells of 4 x 4 px. A cell's threshold is the middle between the darkest and the
//! brightest pixel of the 3 x 3 cells about it, if these differ by more than noise does. In flat surroundings there is
//! no edge to place; there the threshold of the cell above is kept, so that the inside of a large dark circle stays
//! dark, and is only pushed away where the light drifts towards it, so that shading makes no edge of its own.

use super::rows::{BLOCK_ROWS, KEPT_BLOCKS, Rows};
use crate::settings::limits;

/// Width of a cell, px.
pub(crate) const CELL: usize = 4;
/// Ranges of grey levels told apart by the noise figure.
const RANGES: usize = 64;
/// Fractional bits of the smoothed noise figure.
const NOISE_BITS: u32 = 4;

/// Extremes of the cells of three blocks of rows and the thresholds of one.
#[derive(Debug)]
pub(crate) struct Cells<'s> {
    /// Seven sections: minima of three blocks, maxima of three blocks, thresholds.
    data: &'s mut [u8],
    count: usize,
    blocks: u16,
    noise: u16,
}

const THRESHOLDS: usize = 2 * KEPT_BLOCKS;
/// Bytes needed for a frame as wide as the storage, in widths of the frame.
pub(crate) const CELL_WIDTHS: usize = 2;

impl<'s> Cells<'s> {
    pub fn new(data: &'s mut [u8]) -> Self {
        Self { data, count: 0, blocks: 0, noise: 0 }
    }

    pub fn begin(&mut self, width: u16) {
        // An even number: runs are found in eight pixels at a time.
        self.count = usize::from(width).div_ceil(2 * CELL) * 2;
        self.blocks = 0;
        self.noise = 0;
    }

    /// Blocks measured so far.
    pub fn blocks(&self) -> u16 {
        self.blocks
    }

    /// Thresholds of the block in work, one for each cell: a pixel below it is dark.
    pub fn thresholds(&self) -> &[u8] {
        self.data.get(self.section(THRESHOLDS)).unwrap_or(&[])
    }

    /// Smallest difference of grey levels that counts as an edge.
    pub fn min_contrast(&self) -> u8 {
        let contrast = (self.noise * limits::CONTRAST_TO_NOISE) >> NOISE_BITS;
        limits::MIN_CONTRAST.max(contrast.min(255) as u8)
    }

    /// Takes the extremes of the next block of rows (its last rows are repeated where the frame ends).
    pub fn measure(&mut self, rows: &Rows<'_>) {
        let first = self.blocks * BLOCK_ROWS as u16;
        let kept = usize::from(self.blocks) % KEPT_BLOCKS;
        let (minima, maxima) = (self.section(kept), self.section(KEPT_BLOCKS + kept));
        let (low, high) = self.data.split_at_mut_checked(maxima.start).unwrap_or_default();
        let low = low.get_mut(minima.clone()).unwrap_or_default().as_chunks_mut::<2>().0;
        let high = high.get_mut(..self.count).unwrap_or_default().as_chunks_mut::<2>().0;
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| rows.row(first + i).as_chunks::<{ 2 * CELL }>().0.iter());
        for (((((low, high), a), b), c), d) in low.iter_mut().zip(high).zip(a).zip(b).zip(c).zip(d) {
            (*low, *high) = extremes([a, b, c, d]);
        }
        self.blocks += 1;
        self.update_noise(minima, maxima);
    }

    /// The noise figure is the range that one cell in eight stays below: even on a crowded board that many are flat.
    fn update_noise(&mut self, minima: core::ops::Range<usize>, maxima: core::ops::Range<usize>) {
        let mut histogram = [0u16; RANGES];
        let ranges =
            self.data.get(minima).into_iter().flatten().zip(self.data.get(maxima).into_iter().flatten());
        for (low, high) in ranges {
            let range = usize::from(high.saturating_sub(*low)).min(RANGES - 1);
            if let Some(n) = histogram.get_mut(range) {
                *n += 1;
            }
        }
        let wanted = self.count / 8 + 1;
        let mut seen = 0;
        let below = |n: &u16| {
            seen += usize::from(*n);
            seen >= wanted
        };
        let figure = (histogram.iter().position(below).unwrap_or(RANGES - 1) as u16) << NOISE_BITS;
        self.noise = if self.blocks == 1 { figure } else { self.noise - self.noise / 4 + figure / 4 };
    }

    /// Moves the thresholds from the block before to the one above the newest measured.
    pub fn update_thresholds(&mut self) {
        let contrast = self.min_contrast();
        let first_block = self.blocks == 2;
        let (extremes, thresholds) =
            self.data.split_at_mut_checked(THRESHOLDS * self.count).unwrap_or_default();
        let (minima, maxima) = extremes.split_at(extremes.len() / 2);
        let columns = |sections| Columns::new(sections, self.count, first_block);
        let (minima, maxima) = (columns(minima), columns(maxima));
        let column = |cell: usize| (minima.get(cell, u8::min), maxima.get(cell, u8::max));
        let mut here = column(0);
        let mut left = here;
        for (cell, threshold) in thresholds.iter_mut().take(self.count).enumerate() {
            let right = if cell + 1 < self.count { column(cell + 1) } else { here };
            let low = left.0.min(here.0).min(right.0);
            let high = left.1.max(here.1).max(right.1);
            let held = if first_block { None } else { Some(*threshold) };
            *threshold = if high.saturating_sub(low) >= contrast {
                mean(low, high)
            } else {
                keep_off(held, mean(low, high), contrast)
            };
            (left, here) = (here, right);
        }
    }

    fn section(&self, i: usize) -> core::ops::Range<usize> {
        i * self.count..(i + 1) * self.count
    }
}

/// `held`, kept at a distance from the flat level on the side where it is; below the level if there is none yet, so
/// that a frame starts light.
fn keep_off(held: Option<u8>, level: u8, contrast: u8) -> u8 {
    let distance = (level / 8).max(contrast / 2);
    match held {
        Some(held) if level < held => held.max(level.saturating_add(distance)),
        Some(held) => held.min(level.saturating_sub(distance)),
        None => level.saturating_sub(distance),
    }
}

fn mean(low: u8, high: u8) -> u8 {
    (u16::from(low) + u16::from(high)).div_ceil(2) as u8
}

/// The cells of three blocks, one above the other.
struct Columns<'c>([&'c [u8]; KEPT_BLOCKS]);

impl<'c> Columns<'c> {
    /// Nothing is above the first block: the one below it stands for that too.
    fn new(sections: &'c [u8], count: usize, first_block: bool) -> Self {
        let (first, rest) = sections.split_at_checked(count).unwrap_or_default();
        let (second, third) = rest.split_at_checked(count).unwrap_or_default();
        Self([first, second, if first_block { second } else { third }])
    }

    fn get(&self, cell: usize, choose: impl Fn(u8, u8) -> u8) -> u8 {
        match self.0.map(|section| section.get(cell)) {
            [Some(a), Some(b), Some(c)] => choose(*a, choose(*b, *c)),
            _ => 0,
        }
    }
}

/// Smallest and largest levels of two cells side by side. All columns first, because those are done eight at a time.
fn extremes([a, b, c, d]: [&[u8; 2 * CELL]; BLOCK_ROWS]) -> ([u8; 2], [u8; 2]) {
    let low: [u8; 2 * CELL] = core::array::from_fn(|i| a[i].min(b[i]).min(c[i].min(d[i])));
    let high: [u8; 2 * CELL] = core::array::from_fn(|i| a[i].max(b[i]).max(c[i].max(d[i])));
    let least = |[a, b, c, d]: [u8; CELL]| a.min(b).min(c.min(d));
    let most = |[a, b, c, d]: [u8; CELL]| a.max(b).max(c.max(d));
    let halves = |[a, b, c, d, e, f, g, h]: [u8; 2 * CELL]| [[a, b, c, d], [e, f, g, h]];
    (halves(low).map(least), halves(high).map(most))
}
