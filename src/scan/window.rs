//! The rows about the one in work, and the crossings that they show.

use core::ops::Range;

use super::crossings::{Axis, Crossing, NEAR, Stretch, log_length};
use super::rows::{KEPT_ROWS, Rows};

/// Samples needed on either side of a crossing, px.
pub(super) const REACH: u16 = 4;
/// Largest change of level across a crossing's axis in quarters of that along it: room for noise, because at equality
/// either axis is as good.
const MAX_ACROSS: i32 = 5;
/// Most rows on either side for a stretch on a column.
const FAR_ROWS: usize = 4;
/// Rows for the stretches above and below, and the near ones between them.
const ABOUT: usize = FAR_ROWS + NEAR + FAR_ROWS;
/// Rows that are kept, and those without pixels above and below of which stretches are told to keep off.
const ROWS: usize = KEPT_ROWS + 2 * (FAR_ROWS - 1);

/// The rows about one of a block.
pub(super) struct Window<'a> {
    /// From [`REACH`] above the block on, the nearest where there are none; before and after them some without pixels.
    rows: [&'a [u8]; ROWS],
    pub width: u16,
    pub height: u16,
    /// Columns of the rows, with those that pad them.
    padded: u16,
    /// The same where there are rows enough about the row in work for a crossing on a column; otherwise 0.
    columns: u16,
    /// Smallest difference between the two sides' pairs of samples: less is no edge, but the border of two cells'
    /// thresholds.
    min_step: i32,
    /// Rows that are there.
    pushed: u16,
    /// First row of the block.
    first: u16,
    /// The row in work.
    pub y: u16,
    /// The same from the first of the block on.
    row: usize,
    /// Pixels of the stretches above and below on a column, as many as there are rows for; 0 where rows are missing even for
    /// the near samples.
    far: [u16; 2],
}

impl<'a> Window<'a> {
    /// About the block of rows from `first` on, where the smallest contrast of an edge is `min_contrast`.
    pub fn new(rows: &'a Rows<'_>, first: u16, min_contrast: u8) -> Self {
        let mut all: [&[u8]; ROWS] = [&[]; ROWS];
        let kept = rows.rows_after(i32::from(first) - i32::from(REACH));
        let padded = kept[0].len() as u16;
        for (place, row) in all.iter_mut().skip(FAR_ROWS - 1).zip(kept) {
            *place = row;
        }
        Self {
            rows: all,
            width: rows.width(),
            height: rows.height(),
            padded,
            columns: 0,
            min_step: i32::from(min_contrast) / 2,
            pushed: rows.pushed(),
            first,
            y: first,
            row: 0,
            far: [0; 2],
        }
    }

    /// Moves to row `y` of the block, or to the one below the frame.
    pub fn move_to(&mut self, y: u16) {
        self.y = y;
        self.row = usize::from(y - self.first);
        self.far = if y < REACH || y + REACH > self.height {
            [0; 2]
        } else {
            let above = (y - self.first + 1).min(y - REACH + 1);
            let below = self.pushed.saturating_sub(y + REACH - 1);
            let below = below.min(KEPT_ROWS as u16 - (y - self.first) - (2 * REACH - 1));
            [above, below].map(|rows| 1 << log_length(rows.min(FAR_ROWS as u16).into()))
        };
        self.columns = if self.far == [0; 2] { 0 } else { self.padded };
    }

    /// The rows about this one: those of the stretch above from the farthest on, the near ones `y - 3` to `y + 2`, those of the
    /// stretch below.
    #[inline(always)]
    fn about(&self) -> Option<&[&'a [u8]; ABOUT]> {
        self.rows.get(self.row..)?.first_chunk()
    }

    /// The crossing before column `x` of this row; its neighbours are before the columns `before` and `after`.
    #[inline(always)]
    pub fn row_crossing(&self, x: u16, [before, after]: [u16; 2]) -> Option<Crossing> {
        if x < REACH || x + REACH > self.width {
            return None;
        }
        let [_, _, _, _, _, _, above, row, below, ..] = self.about()?;
        let [left, near @ .., right] = from_column::<{ NEAR + 2 }>(row, x - REACH)?;
        let ([a, b], [c, d]) = (from_column(above, x - 1)?, from_column(below, x - 1)?);
        // One by one: a copy of so few bytes would be a call.
        let near = near.map(|level| level);
        if !self.is_edge(&near, [*a, *b, *c, *d]) {
            return None;
        }
        // As far from the next crossing as from this one.
        let clear = |from: u16, to: u16| usize::from(to.saturating_sub(from + 2 * (REACH - 1)));
        let end = usize::from(x - REACH + 1);
        let before = match clear(before, x) {
            0 | 1 => Stretch::of_one(*left),
            clear => {
                let log = log_length(clear.min(end));
                let levels = row.get(end.checked_sub(1 << log)?..end)?;
                Stretch::of(levels, log).unless_clipped(*left, *levels.first()?)
            }
        };
        let after = match clear(x, after.min(self.width)) {
            0 | 1 => Stretch::of_one(*right),
            clear => {
                let log = log_length(clear);
                let levels = row.get(usize::from(x + REACH - 1)..)?.get(..1 << log)?;
                Stretch::of(levels, log).unless_clipped(*right, *levels.last()?)
            }
        };
        Some(Crossing::new(Axis::Row, (x, self.y), near, [before, after]))
    }

    /// The columns `from..to`, if there are rows enough about this one.
    #[inline(always)]
    pub fn columns(&self, from: u16, to: u16) -> Range<u16> {
        if to < self.columns { from..to } else { 0..0 }
    }

    /// The crossing between the row above and this one in column `x`, one of [`columns`](Self::columns).
    #[inline(always)]
    pub fn column_crossing(&self, x: u16) -> Option<Crossing> {
        let [above @ .., r0, r1, r2, r3, r4, r5, b0, b1, b2, b3] = self.about()?;
        // There is none beside the first column.
        let left = x.wrapping_sub(1);
        let ([a, n2, c], [b, n3, d]) = (from_column(r2, left)?, from_column(r3, left)?);
        let level = |row: &[u8]| row.get(usize::from(x)).copied();
        let near = [level(r0)?, level(r1)?, *n2, *n3, level(r4)?, level(r5)?];
        if !self.is_edge(&near, [*a, *b, *c, *d]) {
            return None;
        }
        let [a3, a2, a1, a0] = above;
        let [most_above, most_below] = self.far;
        let far = [
            self.column_stretch(x, [a0, a1, a2, a3], most_above),
            self.column_stretch(x, [b0, b1, b2, b3], most_below),
        ];
        Some(Crossing::new(Axis::Column, (x, self.y), near, far))
    }

    /// The stretch in column `x` of `rows`, the nearest first, `most` of them, as far as its levels are those of an even
    /// surface.
    #[inline(always)]
    fn column_stretch(&self, x: u16, rows: [&[u8]; FAR_ROWS], most: u16) -> Stretch {
        let [nearest, second, third, fourth] =
            rows.map(|row| move || row.get(usize::from(x)).copied().unwrap_or(0));
        let nearest = nearest();
        let even = |level: u8| i32::from(level.abs_diff(nearest)) < self.min_step;
        if most < 2 {
            return Stretch::of_one(nearest);
        }
        let second = second();
        if !even(second) {
            return Stretch::of_one(nearest);
        }
        if most >= 4 {
            let (third, fourth) = (third(), fourth());
            if even(third) && even(fourth) {
                return Stretch::of(&[nearest, second, third, fourth], 2).unless_clipped(nearest, fourth);
            }
        }
        Stretch::of(&[nearest, second], 1).unless_clipped(nearest, second)
    }

    /// Whether the levels change enough along a crossing's axis, and across it not clearly more: then the other axis is
    /// the better one.
    #[inline(always)]
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
