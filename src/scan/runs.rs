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
        let most = self.data.len().min(budget.most_of_row());
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
            if found >= most {
                found += changes.count_ones() as usize;
                continue;
            }
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
        self.len = found.min(most) & !1;
        budget.save(width, 1);
        budget.take(self.len / 2);
        (found - self.len) as u32 / 2
    }
}

/// Bounds the work that a frame can make. It counts pixels: every row brings some, and every piece of work takes a sixth of
/// [`Settings::px_per_run`](crate::Settings::px_per_run). A run is one piece, and about a hundred instructions. A transition at which
/// an outline goes on that keeps its crossings is [`OF_CROSSING`], and so is a column in which such an outline may be crossed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// What a piece of work takes, sixths of a pixel; 0: nothing.
    each: u32,
    /// What is left, and the most that can be saved up.
    left: u32,
    most: u32,
}

/// Parts of a pixel that are counted.
const SIXTHS: u32 = 6;
/// Pieces of work where an outline is crossed.
pub(super) const OF_CROSSING: usize = 2;
/// Rows whose pixels can be saved up: the targets of a board can begin in the same row.
const SAVED_ROWS: u32 = 64;
/// Most transitions of a strip's block while more than a half, a quarter, an eighth of the budget is left, and below. More are
/// noise or print too fine for the pixels; a small target has four in a row.
const MOST_OF_STRIP: [u32; 4] = [40, 32, 24, 16];
/// Share of the budget that is left for runs: without them all outlines would break.
const FOR_RUNS: u32 = 8;
/// What is left for each open outline that keeps crossings, pieces of work: as much as a small target takes.
const FOR_OUTLINE: u32 = 200;

impl Budget {
    pub const NONE: Self = Self { each: 0, left: 0, most: 0 };

    pub fn new(width: u16, px_per_run: u16) -> Self {
        let most = SIXTHS * SAVED_ROWS * u32::from(width);
        Self { each: px_per_run.into(), left: most, most }
    }

    /// Most transitions in the four rows of a strip.
    fn most_of_strip(&self) -> u32 {
        let [plenty, half, quarter, eighth] = MOST_OF_STRIP;
        match self.left {
            _ if self.each == 0 => u32::MAX,
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
        self.left.checked_div(self.each).map_or(usize::MAX, |runs| 2 * runs as usize)
    }

    /// So many rows of this width.
    pub fn save(&mut self, width: u16, rows: u16) {
        self.left = (self.left + SIXTHS * u32::from(width) * u32::from(rows)).min(self.most);
    }

    /// Takes so many pieces of work.
    pub fn take(&mut self, pieces: usize) {
        self.left = self.left.saturating_sub(self.each * pieces as u32);
    }

    /// Whether there is room for so many pieces of work where an outline is crossed.
    pub fn has(&self, pieces: usize) -> bool {
        self.each == 0 || self.left > self.each * pieces as u32 + self.most / FOR_RUNS
    }

    /// Whether an outline that begins is followed, where so many others are and it lies `inside` of one of them. Those that are
    /// open come first: clutter never ends, a target does.
    pub fn admits(&self, others: u16, inside: impl Fn() -> bool) -> bool {
        let spare = self.left.saturating_sub(self.most / FOR_RUNS);
        let room = spare.checked_div(self.each * FOR_OUTLINE);
        room.is_none_or(|outlines| outlines > others.into() || spare > 0 && inside())
    }

    /// Whether there is room for more than runs: a frame that uses its budget up is noise or all clutter.
    pub fn is_ample(&self) -> bool {
        self.each == 0 || self.left > self.most / 2
    }
}
