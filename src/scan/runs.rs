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
        let most = self.data.len().min(budget.most_of_row());
        let mut slots = self.data.get_mut(..most).unwrap_or_default().iter_mut();
        // 1 if the last pixel was dark; transitions that found no slot.
        let (mut before, mut rest) = (0, 0);
        for (x, dark) in strips.dark(row) {
            let mut changes = dark ^ (dark << 1 | before);
            before = dark >> (STRIP - 1);
            while changes != 0 {
                let Some(slot) = slots.next() else {
                    rest += changes.count_ones() as usize;
                    break;
                };
                // What is beyond the frame repeats its last pixel, but may be of another cell.
                slot.x = (x + changes.trailing_zeros() as u16).min(width);
                changes &= changes - 1;
            }
        }
        if before != 0 {
            match slots.next() {
                Some(slot) => slot.x = width,
                None => rest += 1,
            }
        }
        let found = most - slots.len() + rest;
        // Runs are dropped whole, so that the list stays even.
        self.len = found.min(most) & !1;
        budget.take(self.len / 2);
        (found - self.len) as u32 / 2
    }
}

/// Bounds the work that a frame can make, in pieces of about a hundred instructions: a run is one, a place where an outline goes on
/// or may be crossed is [`OF_CROSSING`]. [`Settings::px_per_run`](crate::Settings::px_per_run) pixels bring [`PER_RUN`] of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// What a row brings, 1/[`PIECE`] pieces.
    row: i32,
    /// What is left, and the most that can be saved up.
    left: i32,
    most: i32,
    /// What is left for runs: without them all outlines would break.
    for_runs: i32,
}

/// Pieces of work of a run whose outlines are followed, and of the columns in which they are crossed about it.
const PER_RUN: u32 = 6;
/// Pieces of work where an outline is crossed.
pub(super) const OF_CROSSING: usize = 2;
/// Pieces of work of the threshold of a strip that is not calm, for the four rows of a block.
const OF_STRIP: i32 = 4;
/// Pieces of work of a search for arcs.
const OF_SEARCH: i32 = 600;
/// Parts of a piece.
const PIECE: i32 = 1 << 8;
/// Rows whose pixels can be saved up: the targets of a board can begin in the same row.
const SAVED_ROWS: i32 = 64;
/// Share of what is left that the runs of a row can take.
const SHARE: i32 = 16;
/// More than a row can take.
const UNBOUNDED: i32 = 1 << 24;
/// Most transitions of a strip's block while more than a half, a quarter, an eighth of the budget is left, and below. More are
/// noise or print too fine for the pixels; a small target has four in a row.
const MOST_OF_STRIP: [u32; 4] = [40, 32, 24, 16];
/// Share of the budget that is left for runs.
const FOR_RUNS: i32 = 8;
/// What is left for each outline that is followed, pieces of work: as much as a small target takes.
const FOR_OUTLINE: i32 = 300;

impl Budget {
    /// No bound.
    pub const NONE: Self = Self::of_row(UNBOUNDED);

    const fn of_row(row: i32) -> Self {
        let most = SAVED_ROWS * row;
        Self { row, left: most, most, for_runs: most / FOR_RUNS }
    }

    pub fn new(width: u16, px_per_run: u16) -> Self {
        let width = PER_RUN * PIECE as u32 * u32::from(width);
        Self::of_row(width.checked_div(px_per_run.into()).map_or(UNBOUNDED, |row| row as i32))
    }

    /// Whether there is no bound.
    fn is_unbounded(&self) -> bool {
        self.row == UNBOUNDED
    }

    /// Most transitions in the four rows of a strip.
    fn most_of_strip(&self) -> u32 {
        let [plenty, half, quarter, eighth] = MOST_OF_STRIP;
        match self.left {
            _ if self.is_unbounded() => u32::MAX,
            left if left > self.most / 2 => plenty,
            left if left > self.most / 4 => half,
            left if left > self.most / 8 => quarter,
            _ => eighth,
        }
    }

    /// Takes the work of a strip that has these dark pixels. Returns the runs that are dropped with it; none if it is not too busy.
    pub fn take_strip(&mut self, dark: [u32; BLOCK_ROWS]) -> Option<u32> {
        let changes = dark.map(|dark| ((dark ^ dark >> 1) & (u32::MAX >> 1)).count_ones());
        let changes = changes.iter().sum();
        self.left = (self.left - PIECE * OF_STRIP).max(0);
        (changes > self.most_of_strip()).then_some(u32::div_ceil(changes, 2))
    }

    /// Most transitions of a row. Only a share of what is left: where it changes from row to row, outlines break.
    fn most_of_row(&self) -> usize {
        2 * (self.left.max(0) / (PIECE * SHARE)) as usize
    }

    /// So many rows.
    pub fn save(&mut self, rows: u16) {
        self.left = (self.left + self.row * i32::from(rows)).min(self.most);
    }

    /// Takes so many pieces of work. What a row takes beyond what is left the next ones have less.
    #[inline(always)]
    pub fn take(&mut self, pieces: usize) {
        self.left -= PIECE * pieces as i32;
    }

    /// Takes so many pieces of work where an outline is crossed, if they are there.
    #[inline(always)]
    pub fn take_if_spare(&mut self, pieces: usize) -> bool {
        let left = self.left - PIECE * pieces as i32;
        let is_spare = left > self.for_runs;
        self.left = if is_spare { left } else { self.left };
        is_spare
    }

    /// Whether an outline that begins is followed, where so many others are and it lies `inside` of one of them. Those that are
    /// open come first: clutter never ends, a target does.
    pub fn admits(&self, others: u16, inside: impl Fn() -> bool) -> bool {
        let spare = (self.left - self.for_runs) / PIECE;
        spare > FOR_OUTLINE * i32::from(others) || spare > 0 && inside()
    }

    /// Whether there is room for a search for arcs beside runs: a frame that uses its budget up is noise or all clutter.
    pub fn has_room_for_search(&self) -> bool {
        self.left - PIECE * OF_SEARCH > self.most / 2
    }

    /// Takes the work of one.
    pub fn take_search(&mut self) {
        self.left -= PIECE * OF_SEARCH;
    }
}
