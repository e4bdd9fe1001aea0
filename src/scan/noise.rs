//! How far noise spreads the levels where there is no edge.

use super::strips::Extremes;
use crate::list::rolled;
use crate::settings::limits;

/// Ranges of half grey levels told apart.
const RANGES: usize = 32;
/// Of fewer cells the one in eight that is lowest may by chance be far below what it is of many: room for two standard
/// deviations of its number.
const FEW_CELLS: u16 = 32;
/// Fractional bits of the figure.
const NOISE_BITS: u32 = 4;

/// What noise makes of cells without edges.
#[derive(Clone, Copy, Debug)]
// Copied by words.
#[repr(align(4))]
pub(crate) struct Noise {
    /// Cells by the difference of their samples.
    ranges: [u16; RANGES],
    pub count: u16,
    /// The range that one cell in eight stays below: even on a crowded board that many are flat.
    figure: u16,
    /// Smallest difference of half levels that counts as an edge.
    pub contrast: u8,
}

impl Noise {
    pub const NONE: Self =
        Self { ranges: [0; RANGES], count: 0, figure: 0, contrast: limits::MIN_CONTRAST.div_ceil(2) };

    /// Adds the first `cells` of a strip.
    pub fn add(&mut self, [low, high]: Extremes, cells: usize) {
        for range in rolled((high - low).to_le_bytes().into_iter().take(cells)) {
            if let Some(count) = self.ranges.get_mut(usize::from(range)) {
                *count += 1;
            }
            self.count += 1;
        }
    }

    /// Adds those of the first `cells` of a strip in which there is no edge: noise, and light that changes slowly.
    pub fn add_flat(&mut self, [low, high]: Extremes, cells: usize) {
        for range in (high - low).to_le_bytes().into_iter().take(cells) {
            if range < self.contrast
                && let Some(count) = self.ranges.get_mut(usize::from(range))
            {
                *count += 1;
                self.count += 1;
            }
        }
    }

    /// Takes the cells of `other` instead.
    pub fn replace(&mut self, other: &Self) {
        (self.ranges, self.count) = (other.ranges, other.count);
    }

    /// Takes the figure from the cells, and forgets these.
    pub fn settle(&mut self) {
        if self.count == 0 {
            return;
        }
        let room = if self.count < FEW_CELLS { 2 * self.count.isqrt() / 3 } else { 0 };
        let wanted = self.count / 8 + 1 + room;
        let mut seen = 0;
        // Where all have wider ranges there is no noise to be seen for all the edges.
        let mut figure = self.figure;
        for (range, &count) in rolled(self.ranges.iter().enumerate()) {
            if seen + count >= wanted {
                // A range stands for those half a level below and above it.
                let share = ((wanted - seen) << NOISE_BITS) / count.max(1);
                figure = (((range as u16) << NOISE_BITS) + share).saturating_sub(1 << (NOISE_BITS - 1));
                break;
            }
            seen += count;
        }
        // A figure that is far too large was one of edges.
        let edges = figure < self.figure / 2;
        self.figure =
            if self.figure == 0 || edges { figure } else { self.figure - self.figure / 4 + figure / 4 };
        let contrast = (u32::from(self.figure) * limits::CONTRAST_TO_NOISE) >> (NOISE_BITS + 1);
        self.contrast = contrast.clamp(u32::from(limits::MIN_CONTRAST / 2), 127) as u8;
        (self.ranges, self.count) = ([0; RANGES], 0);
    }
}
