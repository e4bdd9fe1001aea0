//! Where a row passes the threshold.

use super::rows::BLOCK_ROWS;
use super::strips::{STRIP, Strips};

/// A run: a longest stretch of dark pixels in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// Column of its first pixel.
    pub start: u16,
    /// Column after its last pixel.
    pub end: u16,
}

/// A run that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RunError {
    /// Its number in the row.
    pub at: usize,
}

/// The first pixel of a run: a row turns dark at the even entries of its list and light at the odd ones.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transition {
    /// Column of the first pixel after the change.
    pub x: u16,
    /// Outline that it belongs to.
    pub label: u16,
}

impl Transition {
    pub const ZERO: Self = Self { x: 0, label: 0 };
}

/// The transitions of a row, in order; an even number, because what is outside the frame counts as light.
#[derive(Debug)]
pub(crate) struct TransitionList<'s> {
    data: &'s mut [Transition],
    len: usize,
}

impl<'s> TransitionList<'s> {
    pub fn new(data: &'s mut [Transition]) -> Self {
        Self { data, len: 0 }
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    pub fn as_slice(&self) -> &[Transition] {
        self.data.get(..self.len).unwrap_or(&[])
    }

    pub fn as_mut_slice(&mut self) -> &mut [Transition] {
        self.data.get_mut(..self.len).unwrap_or(&mut [])
    }

    /// Takes the dark runs of row `row` of the block in work, in a frame of this width, as far as the budget allows. Returns
    /// how many were dropped.
    pub fn fill(&mut self, strips: &Strips<'_>, row: usize, width: u16, budget: &mut Budget) -> u32 {
        let mut found = 0;
        let mut push = |at: usize, x: u16| {
            if let Some(slot) = self.data.get_mut(at) {
                slot.x = x;
            }
        };
        // 1 if the last pixel was dark.
        let mut before = 0;
        for (x, dark) in strips.dark(row) {
            let mut changes = dark ^ (dark << 1 | before);
            before = dark >> (STRIP - 1);
            while changes != 0 {
                // What is beyond the frame repeats its last pixel, but may be of another cell.
                push(found, (x + changes.trailing_zeros() as u16).min(width));
                changes &= changes - 1;
                found += 1;
            }
        }
        if before != 0 {
            push(found, width);
            found += 1;
        }
        // Runs are dropped whole, so that the list stays even.
        self.len = found.min(self.data.len()).min(budget.most_of_row()) & !1;
        budget.take(width, self.len / 2);
        (found - self.len) as u32 / 2
    }
}

/// Bounds the work that a frame can make. It counts pixels: every row brings some, every run takes
/// [`Settings::px_per_run`](crate::Settings::px_per_run).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    px_per_run: u32,
    /// Pixels left, and the most that can be saved up.
    left: u32,
    most: u32,
}

/// Rows whose pixels can be saved up: the targets of a board can begin in the same row.
const SAVED_ROWS: u32 = 64;
/// Most transitions of a strip's block while more than a half, a quarter, an eighth of the budget is left, and below. More are
/// noise or print too fine for the pixels; a small target has four in a row.
const MOST_OF_STRIP: [u32; 4] = [48, 32, 24, 16];

impl Budget {
    pub const NONE: Self = Self { px_per_run: 0, left: 0, most: 0 };

    pub fn new(width: u16, px_per_run: u16) -> Self {
        let most = SAVED_ROWS * u32::from(width);
        Self { px_per_run: px_per_run.into(), left: most, most }
    }

    /// Most transitions in the four rows of a strip.
    fn most_of_strip(&self) -> u32 {
        let [plenty, half, quarter, eighth] = MOST_OF_STRIP;
        match self.left {
            _ if self.px_per_run == 0 => u32::MAX,
            left if left > self.most / 2 => plenty,
            left if left > self.most / 4 => half,
            left if left > self.most / 8 => quarter,
            _ => eighth,
        }
    }

    /// The runs that are dropped with a strip that has these dark pixels; none if it is not too busy.
    pub fn dropped_of_strip(&self, dark: [u32; BLOCK_ROWS]) -> Option<u32> {
        let changes = dark.map(|dark| ((dark ^ dark >> 1) & (u32::MAX >> 1)).count_ones());
        let changes = changes.iter().sum();
        (changes > self.most_of_strip()).then_some(u32::div_ceil(changes, 2))
    }

    /// Most transitions of a row.
    fn most_of_row(&self) -> usize {
        self.left.checked_div(self.px_per_run).map_or(usize::MAX, |runs| 2 * runs as usize)
    }

    /// A row of this width with so many runs.
    fn take(&mut self, width: u16, runs: usize) {
        let left = self.left.saturating_sub(self.px_per_run * runs as u32);
        self.left = (left + u32::from(width)).min(self.most);
    }

    /// So many rows of this width without a run.
    pub fn save(&mut self, width: u16, rows: u16) {
        self.left = (self.left + u32::from(width) * u32::from(rows)).min(self.most);
    }

    /// Whether there is room for more than runs: a frame that uses its budget up is noise or all clutter.
    pub fn is_ample(&self) -> bool {
        self.px_per_run == 0 || self.left > self.most / 2
    }
}
