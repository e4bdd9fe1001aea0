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
/// Pixels whose extremes are taken together, in loops long enough to be done many bytes at a time.
const STRIP: usize = 64;

/// Extremes of the cells of three blocks of rows, and the thresholds of one.
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

/// What a whole cell is in every row of its block.
pub(crate) mod state {
    pub const LIGHT: u8 = 0;
    pub const DARK: u8 = u8::MAX;
    pub const MIXED: u8 = 1;
}

impl<'s> Cells<'s> {
    pub fn new(data: &'s mut [u8]) -> Self {
        Self { data, count: 0, blocks: 0, noise: 0 }
    }

    pub fn begin(&mut self, width: u16) {
        // An even number: runs are found in eight pixels at a time.
        self.count = usize::from(width).div_ceil(2 * CELL) * 2;
        self.blocks = 0;
        self.noise = 0;
        // Nothing is above the first block, and a frame starts light.
        self.data.fill(0);
        let minima = self.section(KEPT_BLOCKS - 1);
        self.data.get_mut(minima).unwrap_or_default().fill(u8::MAX);
    }

    /// Blocks measured so far.
    pub fn blocks(&self) -> u16 {
        self.blocks
    }

    /// Thresholds of the block in work, one for each cell: a pixel below it is dark.
    pub fn thresholds(&self) -> &[u8] {
        self.data.get(self.section(THRESHOLDS)).unwrap_or(&[])
    }

    /// A [`state`] for each cell of the block in work.
    pub fn states(&self) -> &[u8] {
        self.data.get(self.section(self.kept(0))).unwrap_or(&[])
    }

    /// Smallest difference of grey levels that counts as an edge.
    pub fn min_contrast(&self) -> u8 {
        let contrast = (self.noise * limits::CONTRAST_TO_NOISE) >> NOISE_BITS;
        limits::MIN_CONTRAST.max(contrast.min(255) as u8)
    }

    /// Takes the extremes of the next block of rows (its last rows are repeated where the frame ends).
    pub fn measure(&mut self, rows: &Rows<'_>) {
        let first = self.blocks * BLOCK_ROWS as u16;
        let kept = self.kept(0);
        let sections = [self.section(kept), self.section(KEPT_BLOCKS + kept)];
        let Ok([minima, maxima]) = self.data.get_disjoint_mut(sections) else { return };
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| rows.row(first + i).chunks(STRIP));
        let strips = a.zip(b).zip(c.zip(d));
        let cells = minima.chunks_mut(STRIP / CELL).zip(maxima.chunks_mut(STRIP / CELL));
        for ((low, high), ((a, b), (c, d))) in cells.zip(strips) {
            extremes([a, b, c, d], low, high);
        }
        let figure = noise_figure(minima, maxima) << NOISE_BITS;
        self.noise = if self.blocks == 0 { figure } else { self.noise - self.noise / 4 + figure / 4 };
        self.blocks += 1;
    }

    /// Moves the thresholds from the block before to the one above the newest measured, and finds the states of its cells.
    pub fn update_thresholds(&mut self) {
        let contrast = self.min_contrast();
        let sections = [0, 1, 2].map(|age| self.kept(age));
        let [low_above, low, low_below] = sections.map(|kept| self.section(kept));
        let [high_above, high, high_below] = sections.map(|kept| self.section(KEPT_BLOCKS + kept));
        let ranges = [low_above, low, low_below, high_above, high, high_below, self.section(THRESHOLDS)];
        let Ok(sections) = self.data.get_disjoint_mut(ranges) else { return };
        // What is above is not needed again: the columns, then the states, take its place.
        let [low_columns, low, low_below, high_columns, high, high_below, thresholds] = sections;
        fold(low_columns, low, low_below, u8::min);
        fold(high_columns, high, high_below, u8::max);
        move_thresholds(low_columns, high_columns, thresholds, contrast);
        for (((state, low), high), threshold) in low_columns.iter_mut().zip(low).zip(high).zip(thresholds) {
            let some = if *high < *threshold { state::DARK } else { state::MIXED };
            *state = if *low >= *threshold { state::LIGHT } else { some };
        }
    }

    fn section(&self, i: usize) -> core::ops::Range<usize> {
        i * self.count..(i + 1) * self.count
    }

    /// Where a block's extremes are, `age` after the oldest one, which the next one to be measured replaces.
    fn kept(&self, age: usize) -> usize {
        (usize::from(self.blocks) + age) % KEPT_BLOCKS
    }
}

/// Extremes of a strip of four rows, cell by cell.
fn extremes([a, b, c, d]: [&[u8]; BLOCK_ROWS], minima: &mut [u8], maxima: &mut [u8]) {
    // The last steps reach two pixels past the strip's last cell, which has no use for them.
    let (mut low, mut high) = ([0; STRIP + 2], [0; STRIP + 2]);
    for ((low, high), ((a, b), (c, d))) in
        low.iter_mut().zip(&mut high).zip(a.iter().zip(b).zip(c.iter().zip(d)))
    {
        *low = *a.min(b).min(c.min(d));
        *high = *a.max(b).max(c.max(d));
    }
    for step in [2, 1] {
        for i in 0..STRIP {
            low[i] = low[i].min(low[i + step]);
            high[i] = high[i].max(high[i + step]);
        }
    }
    let cells = low.as_chunks::<CELL>().0.iter().zip(high.as_chunks::<CELL>().0);
    for ((minimum, maximum), (low, high)) in minima.iter_mut().zip(maxima).zip(cells) {
        (*minimum, *maximum) = (low[0], high[0]);
    }
}

/// The range that one cell in eight stays below: even on a crowded board that many are flat.
fn noise_figure(minima: &[u8], maxima: &[u8]) -> u16 {
    let mut histogram = [0u16; RANGES];
    for (low, high) in minima.iter().zip(maxima) {
        histogram[usize::from(high.saturating_sub(*low)).min(RANGES - 1)] += 1;
    }
    let wanted = minima.len() / 8 + 1;
    let mut seen = 0;
    let below = |n: &u16| {
        seen += usize::from(*n);
        seen >= wanted
    };
    histogram.iter().position(below).unwrap_or(RANGES - 1) as u16
}

/// `choose` over three blocks, in place of the first.
fn fold(first: &mut [u8], second: &[u8], third: &[u8], choose: impl Fn(u8, u8) -> u8) {
    for ((first, second), third) in first.iter_mut().zip(second).zip(third) {
        *first = choose(*first, choose(*second, *third));
    }
}

/// The new thresholds from the extremes of columns of three cells.
fn move_thresholds(low: &[u8], high: &[u8], thresholds: &mut [u8], contrast: u8) {
    let [first, inner @ .., last] = thresholds else { return };
    for (held, low, high) in [
        (first, low.first_chunk::<2>(), high.first_chunk::<2>()),
        (last, low.last_chunk::<2>(), high.last_chunk::<2>()),
    ] {
        if let (Some([a, b]), Some([c, d])) = (low, high) {
            *held = threshold(*held, *a.min(b), *c.max(d), contrast);
        }
    }
    for ((held, low), high) in inner.iter_mut().zip(low.windows(3)).zip(high.windows(3)) {
        if let ([a, b, c], [d, e, f]) = (low, high) {
            *held = threshold(*held, *a.min(b).min(c), *d.max(e).max(f), contrast);
        }
    }
}

/// The middle between `low` and `high`, or in flat surroundings the threshold `held`, kept at a distance from them on the
/// side where it is.
fn threshold(held: u8, low: u8, high: u8, contrast: u8) -> u8 {
    let middle = (u16::from(low) + u16::from(high)).div_ceil(2) as u8;
    let distance = (middle / 8).max(contrast / 2);
    let kept = if middle < held {
        held.max(middle.saturating_add(distance))
    } else {
        held.min(middle.saturating_sub(distance))
    };
    if high.saturating_sub(low) >= contrast { middle } else { kept }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;

    /// A width that is no multiple of a strip.
    #[test]
    fn extremes_and_states_are_those_of_the_pixels() {
        const WIDTH: usize = 136;
        // Flat first, then stripes of 10 px.
        let level = |x: usize, y: usize| match x {
            0..48 => 200,
            _ => (60 + x / 10 % 2 * 120 + (x * 7919 + y * 104_729 + x * x * y) % 31) as u8,
        };
        let (mut kept, mut data) = (vec![0; 12 * WIDTH], vec![0; CELL_WIDTHS * WIDTH]);
        let (mut rows, mut cells) = (Rows::new(&mut kept), Cells::new(&mut data));
        rows.begin(WIDTH as u16, 8);
        cells.begin(WIDTH as u16);
        for y in 0..2 * BLOCK_ROWS {
            rows.push(&core::array::from_fn::<u8, WIDTH, _>(|x| level(x, y)));
            if rows.block_complete() {
                cells.measure(&rows);
            }
        }
        let block = |cell: usize| {
            (0..CELL).flat_map(move |x| (0..BLOCK_ROWS).map(move |y| level(CELL * cell + x, y)))
        };
        let minima: vec::Vec<u8> = (0..WIDTH / CELL).map(|cell| block(cell).min().unwrap()).collect();
        let maxima: vec::Vec<u8> = (0..WIDTH / CELL).map(|cell| block(cell).max().unwrap()).collect();
        assert_eq!(cells.data[cells.section(0)], minima);
        assert_eq!(cells.data[cells.section(KEPT_BLOCKS)], maxima);
        cells.update_thresholds();
        let mut seen = [0; 3];
        for (cell, (&state, &threshold)) in cells.states().iter().zip(cells.thresholds()).enumerate() {
            let dark = block(cell).filter(|&level| level < threshold).count();
            let (kind, want) = match dark {
                0 => (0, state::LIGHT),
                16 => (1, state::DARK),
                _ => (2, state::MIXED),
            };
            assert_eq!(state, want, "cell {cell}");
            seen[kind] += 1;
        }
        assert!(seen.iter().all(|&cells| cells > 0), "{seen:?}");
    }
}
