//! The rows about the one in work, and the crossings that they show.

use core::ops::Range;

use super::crossings::{Axis, Crossing, NEAR, Stretch, log_length};
use super::rows::{KEPT_ROWS, Rows};

/// Samples needed on either side of a crossing, px.
pub(super) const REACH: u16 = 4;
/// Largest change of level across a crossing's axis in quarters of that along it: room for noise, because at equality
/// either axis is as good.
const MAX_ACROSS: i32 = 5;
/// Rows, those that are kept and some without pixels.
const ROWS: usize = KEPT_ROWS.next_power_of_two();
/// Most rows on either side for a stretch on a column.
const FAR_ROWS: u16 = 4;

/// The rows about one of a block.
pub(super) struct Window<'a> {
    /// From [`REACH`] above the block on; the nearest where there are none. A power of two of them is looked up without a
    /// check.
    rows: [&'a [u8]; ROWS],
    pub width: u16,
    pub height: u16,
    /// Smallest difference between the two sides' pairs of samples: less is no edge, but the border of two cells'
    /// thresholds.
    min_step: i32,
    /// Rows that are there.
    pushed: u16,
    /// First row of the block.
    first: u16,
    /// The row in work.
    pub y: u16,
    /// The rows `y - 3` to `y + 2`.
    near: [&'a [u8]; NEAR],
    /// Pixels of the stretches above and below on a column, as many as there are rows for; 0 where rows are missing even for
    /// the near samples.
    far: [u16; 2],
}

impl<'a> Window<'a> {
    /// About the block of rows from `first` on, where the smallest contrast of an edge is `min_contrast`.
    pub fn new(rows: &'a Rows<'_>, first: u16, min_contrast: u8) -> Self {
        let mut all: [&[u8]; ROWS] = [&[]; ROWS];
        for (place, row) in all.iter_mut().zip(rows.rows_after(i32::from(first) - i32::from(REACH))) {
            *place = row;
        }
        Self {
            rows: all,
            width: rows.width(),
            height: rows.height(),
            min_step: i32::from(min_contrast) / 2,
            pushed: rows.pushed(),
            first,
            y: first,
            near: [&[]; NEAR],
            far: [0; 2],
        }
    }

    /// Moves to row `y` of the block, or to the one below the frame.
    pub fn move_to(&mut self, y: u16) {
        self.y = y;
        let row = usize::from(y - self.first);
        if let Some(near) = self.rows.get(row + 1..).and_then(<[_]>::first_chunk) {
            self.near = *near;
        }
        self.far = if y < REACH || y + REACH > self.height {
            [0; 2]
        } else {
            let above = (y - self.first + 1).min(y - REACH + 1);
            let below = self.pushed.saturating_sub(y + REACH - 1);
            let below = below.min(KEPT_ROWS as u16 - (y - self.first) - (2 * REACH - 1));
            [above, below].map(|rows| 1 << log_length(rows.min(FAR_ROWS).into()))
        };
    }

    /// The crossing before column `x` of this row; its neighbours are before the columns `before` and `after`.
    pub fn row_crossing(&self, x: u16, [before, after]: [u16; 2]) -> Option<Crossing> {
        if x < REACH || x + REACH > self.width {
            return None;
        }
        let [_, _, above, row, below, _] = self.near;
        let near = from_column(row, x - 3)?;
        let ([a, b], [c, d]) = (from_column(above, x - 1)?, from_column(below, x - 1)?);
        if !self.is_edge(near, [*a, *b, *c, *d]) {
            return None;
        }
        // As far from the next crossing as from this one.
        let clear = |from: u16, to: u16| usize::from(to.saturating_sub(from + 2 * (REACH - 1)));
        let (left, right) = (usize::from(x - REACH + 1), usize::from(x + REACH - 1));
        let log = log_length(clear(before, x).min(left));
        let levels = row.get(left.checked_sub(1 << log)?..left)?;
        let (farthest, nearest) = (*levels.first()?, *levels.last()?);
        let before = Stretch::of(levels, log).unless_clipped(nearest, farthest);
        let log = log_length(clear(x, after));
        let levels = row.get(right..right + (1 << log))?;
        let (nearest, farthest) = (*levels.first()?, *levels.last()?);
        let after = Stretch::of(levels, log).unless_clipped(nearest, farthest);
        Some(Crossing::new(Axis::Row, (x, self.y), *near, [before, after]))
    }

    /// The columns of `from..to` that have neighbours, if there are rows enough about this one.
    pub fn columns(&self, from: u16, to: u16) -> Range<u16> {
        let [row, ..] = self.near;
        if self.far == [0; 2] || usize::from(to) >= row.len() { 0..0 } else { from.max(1)..to }
    }

    /// The crossing between the row above and this one in column `x`, one of [`columns`](Self::columns).
    pub fn column_crossing(&self, x: u16) -> Option<Crossing> {
        let [above, below] = self.far;
        let [r0, r1, r2, r3, r4, r5] = self.near;
        let ([a, n2, c], [b, n3, d]) = (from_column(r2, x - 1)?, from_column(r3, x - 1)?);
        let level = |row: &[u8]| row.get(usize::from(x)).copied();
        let near = [level(r0)?, level(r1)?, *n2, *n3, level(r4)?, level(r5)?];
        if !self.is_edge(&near, [*a, *b, *c, *d]) {
            return None;
        }
        let row = usize::from(self.y - self.first);
        let below_near = row + usize::from(2 * REACH - 1);
        let far = [
            self.column_stretch(usize::from(x), |i| row.wrapping_sub(i), above),
            self.column_stretch(usize::from(x), |i| below_near + i, below),
        ];
        Some(Crossing::new(Axis::Column, (x, self.y), near, far))
    }

    /// The stretch in column `x` of the rows that `number` numbers from the nearest on, `most` of them, as far as its levels
    /// are those of an even surface.
    #[inline(always)]
    fn column_stretch(&self, x: usize, number: impl Fn(usize) -> usize, most: u16) -> Stretch {
        let level = |i: usize| self.rows[number(i) % ROWS].get(x).copied().unwrap_or(0);
        let nearest = level(0);
        let even = |level: u8| i32::from(level.abs_diff(nearest)) < self.min_step;
        if most < 2 {
            return Stretch::of(&[nearest], 0);
        }
        let second = level(1);
        if !even(second) {
            return Stretch::of(&[nearest], 0);
        }
        if most >= 4 {
            let (third, fourth) = (level(2), level(3));
            if even(third) && even(fourth) {
                return Stretch::of(&[nearest, second, third, fourth], 2).unless_clipped(nearest, fourth);
            }
        }
        Stretch::of(&[nearest, second], 1).unless_clipped(nearest, second)
    }

    /// Whether the levels change enough along a crossing's axis, and across it not clearly more: then the other axis is
    /// the better one.
    fn is_edge(&self, near: &[u8; NEAR], across: [u8; 4]) -> bool {
        let difference = |[a, b, c, d]: [i32; 4]| (c + d - a - b).abs();
        let [_, a, b, c, d, _] = near.map(i32::from);
        let along = difference([a, b, c, d]);
        along >= self.min_step && 4 * difference(across.map(i32::from)) <= MAX_ACROSS * along
    }
}

/// Pixels of `row` from column `x` on.
fn from_column<const N: usize>(row: &[u8], x: u16) -> Option<&[u8; N]> {
    row.get(usize::from(x)..)?.first_chunk()
}
