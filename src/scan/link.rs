//! Joins the transitions of a row to those of the row above.
//!
//! Dark runs are connected when they touch, corners included; light runs when they share a side. Between two rows an
//! outline goes on (a transition has one above it), begins (two neighbouring transitions have none above) or ends (two
//! neighbouring transitions have none below); an outline whose ends have all met is closed. The work is proportional
//! to the number of transitions, except that joined outlines are renamed once a row.

use super::crossings::{Axis, Crossing, CrossingList, NEAR, Pool, Stretch, stretch_length};
use super::outlines::{NONE, Outlines};
use super::rows::{KEPT_ROWS, Rows};
use super::runs::Transition;
use crate::reject::Dropped;
use crate::settings::limits;

/// Steepest step from row to row, px, at which the crossing on the row is kept: beyond it the one on the column is the
/// better one.
const MAX_ROW_STEP: u16 = 2;
/// Largest change of level across a crossing's axis in quarters of that along it: room for noise, because at equality
/// either axis is as good.
const MAX_ACROSS: i32 = 5;
/// Samples needed on either side of a crossing, px.
const REACH: u16 = 4;

pub(crate) struct Linker<'a, 's> {
    /// The rows about the block in work, from [`REACH`] above it on; the nearest where there are none.
    rows: [&'a [u8]; KEPT_ROWS],
    width: u16,
    height: u16,
    outlines: &'a mut Outlines<'s>,
    pool: &'a mut Pool<'s>,
    dropped: &'a mut Dropped,
    /// Smallest difference between the two sides' pairs of samples: less is no edge, but the border of two cells'
    /// thresholds.
    min_step: i32,
    /// Rows that are there.
    pushed: u16,
    /// First row of the block in work.
    first: u16,
    /// The row of `current`.
    y: u16,
    /// The rows `y - 2` to `y + 1`; those outside the frame are not of use.
    near: [&'a [u8]; NEAR],
}

impl<'a, 's> Linker<'a, 's> {
    /// For the block of rows from `first` on, where the smallest contrast of an edge is `min_contrast`.
    pub fn new(
        rows: &'a Rows<'s>,
        outlines: &'a mut Outlines<'s>,
        pool: &'a mut Pool<'s>,
        dropped: &'a mut Dropped,
        (first, min_contrast): (u16, u8),
    ) -> Self {
        let (width, height, pushed) = (rows.width(), rows.height(), rows.pushed());
        let min_step = i32::from(min_contrast) / 2;
        let rows = rows.rows_after(i32::from(first) - i32::from(REACH));
        Self {
            rows,
            width,
            height,
            outlines,
            pool,
            dropped,
            min_step,
            pushed,
            first,
            y: first,
            near: [&[]; NEAR],
        }
    }

    /// Gives every transition of `current`, in row `y` of the block or in the one below the frame, its outline; `previous` is
    /// the row above.
    pub fn link_row(&mut self, y: u16, previous: &[Transition], current: &mut [Transition]) {
        self.y = y;
        self.near = [0, 1, 2, 3, 4, 5].map(|i| self.row_from_above(REACH - 3 + i));
        self.link(previous, current);
    }

    /// The row `i` below the one that is [`REACH`] above row `y`.
    fn row_from_above(&self, i: u16) -> &'a [u8] {
        self.rows.get(usize::from(self.y - self.first + i)).copied().unwrap_or(&[])
    }

    fn link(&mut self, previous: &[Transition], current: &mut [Transition]) {
        let (mut i, mut j) = (0, 0);
        loop {
            let (above, here) = (run(previous, i), run(current, j));
            if above.is_none() && here.is_none() {
                break;
            } else if lies_left(above, here) {
                self.end(previous, 2 * i);
                i += 1;
            } else if lies_left(here, above) {
                self.begin(current, 2 * j);
                j += 1;
            } else {
                self.proceed(previous.get(2 * i), current, 2 * j);
                (i, j) = self.link_connected(previous, current, i, j);
            }
        }
        if self.outlines.any_joined() {
            for transition in current {
                transition.label = self.outlines.root(transition.label);
            }
            self.outlines.free_joined();
        }
    }

    /// Follows a set of connected runs, from run `i` above and run `j` here, to its right end. Returns the runs after it.
    fn link_connected(
        &mut self,
        previous: &[Transition],
        current: &mut [Transition],
        mut i: usize,
        mut j: usize,
    ) -> (usize, usize) {
        loop {
            if touches(run(previous, i + 1), run(current, j)) {
                self.end(previous, 2 * i + 1);
                i += 1;
            } else if touches(run(current, j + 1), run(previous, i)) {
                self.begin(current, 2 * j + 1);
                j += 1;
            } else {
                self.proceed(previous.get(2 * i + 1), current, 2 * j + 1);
                return (i + 1, j + 1);
            }
        }
    }

    /// An outline goes on from the transition `above` to the one `at`.
    fn proceed(&mut self, above: Option<&Transition>, current: &mut [Transition], at: usize) {
        let x = |at: usize| current.get(at).map(|transition| transition.x);
        let before = at.checked_sub(1).and_then(x).unwrap_or(0);
        let after = x(at + 1).unwrap_or(self.width);
        let (Some(above), Some(here)) = (above, current.get_mut(at)) else { return };
        let label = self.outlines.root(above.label);
        here.label = label;
        // Dark begins at the even transitions.
        self.add_transition(label, if at.is_multiple_of(2) { -1 } else { 1 }, here.x);
        if above.x.abs_diff(here.x) <= MAX_ROW_STEP
            && let Some(crossing) = self.row_crossing(here.x, [before, after])
        {
            self.keep(label, crossing);
        }
        if above.x != here.x {
            self.keep_column_crossings(label, above.x.min(here.x), above.x.max(here.x));
        }
    }

    /// An outline begins with the transitions `at` and `at + 1`.
    fn begin(&mut self, current: &mut [Transition], at: usize) {
        let Some([first, second]) = current.get_mut(at..at + 2) else { return };
        let label = self.outlines.open(first.x, self.y);
        if label == NONE {
            self.dropped.outlines = self.dropped.outlines.saturating_add(1);
        }
        (first.label, second.label) = (label, label);
        let sign = if at.is_multiple_of(2) { -1 } else { 1 };
        self.add_transition(label, sign, first.x);
        self.add_transition(label, -sign, second.x);
        self.keep_column_crossings(label, first.x, second.x);
    }

    /// The transitions `at` and `at + 1` of the row above meet.
    fn end(&mut self, previous: &[Transition], at: usize) {
        let Some([first, second]) = previous.get(at..at + 2) else { return };
        let (a, b) = (self.outlines.root(first.label), self.outlines.root(second.label));
        let (label, ends) = if a == NONE || b == NONE {
            // One side was lost; what is left of the other can no longer be trusted.
            let label = if a == NONE { b } else { a };
            self.give_up(label);
            (label, if a == b { 2 } else { 1 })
        } else {
            self.join(a, b);
            (a, 2)
        };
        if self.y == self.height {
            self.mark_cut(label);
        }
        self.keep_column_crossings(label, first.x, second.x);
        self.outlines.end(label, ends);
    }

    fn join(&mut self, a: u16, b: u16) {
        if a == b {
            return;
        }
        let moved =
            self.outlines.get_mut(b).map(|o| core::mem::replace(&mut o.crossings, CrossingList::EMPTY));
        if let (Some(moved), Some(outline)) = (moved, self.outlines.get_mut(a)) {
            self.pool.append(&mut outline.crossings, moved);
        }
        self.outlines.join(a, b, self.y);
        let spoiled = self.outlines.get(a).is_some_and(|o| o.lossy);
        if spoiled {
            self.free_crossings(a);
        }
        self.bound_cut(a);
    }

    fn add_transition(&mut self, label: u16, sign: i32, x: u16) {
        let cut = x == 0 || x >= self.width || self.y == 0;
        if let Some(outline) = self.outlines.get_mut(label) {
            outline.add_transition(sign, x, self.y);
            if cut {
                self.mark_cut(label);
            }
        }
    }

    fn mark_cut(&mut self, label: u16) {
        if let Some(outline) = self.outlines.get_mut(label) {
            outline.cut = true;
        }
        self.bound_cut(label);
    }

    /// An outline that the frame cuts gives up when it has many crossings: it is more often background than a target.
    fn bound_cut(&mut self, label: u16) {
        let most = self.pool.capacity() / limits::CUT_SHARE;
        if self.outlines.get(label).is_some_and(|o| o.cut && usize::from(o.crossings.len()) > most) {
            self.give_up(label);
        }
    }

    fn give_up(&mut self, label: u16) {
        if let Some(outline) = self.outlines.get_mut(label) {
            outline.lossy = true;
            self.free_crossings(label);
        }
    }

    fn free_crossings(&mut self, label: u16) {
        if let Some(outline) = self.outlines.get_mut(label) {
            self.pool.free(&mut outline.crossings);
        }
    }

    /// The crossing before column `x` of this row; its neighbours are before the columns `before` and `after`.
    fn row_crossing(&self, x: u16, [before, after]: [u16; 2]) -> Option<Crossing> {
        if x < REACH || x + REACH > self.width {
            return None;
        }
        let [_, _, above, row, below, _] = self.near;
        let near = from_column(row, x - 3)?;
        let ([a, b], [c, d]) = (from_column(above, x - 1)?, from_column(below, x - 1)?);
        if !self.is_edge(near.map(i32::from), [*a, *b, *c, *d]) {
            return None;
        }
        // As far from the next crossing as from this one.
        let clear = |from: u16, to: u16| usize::from(to.saturating_sub(from + 2 * (REACH - 1)));
        let (left, right) = (usize::from(x - REACH + 1), usize::from(x + REACH - 1));
        let length = stretch_length(clear(before, x).min(left));
        let before = row.get(left.checked_sub(length)?..left)?;
        let after = row.get(right..right + stretch_length(clear(x, after)))?;
        let before = if tells_light(before.last(), before.first()) {
            before
        } else {
            row.get(left.checked_sub(1)?..left)?
        };
        let after = if tells_light(after.first(), after.last()) { after } else { after.get(..1)? };
        Some(Crossing::new(Axis::Row, (x, self.y), *near, [before, after].map(Stretch::new)))
    }

    /// Keeps the crossings between the row above and this one in the columns `from..to`.
    fn keep_column_crossings(&mut self, label: u16, from: u16, to: u16) {
        if self.y < REACH || self.y + REACH > self.height {
            return;
        }
        let columns = usize::from(from.max(1))..usize::from(to);
        let around = columns.start - 1..columns.end + 1;
        let [r0, r1, r2, r3, r4, r5] = self.near;
        let (Some(r1), Some(r2)) = (r1.get(columns.clone()), r2.get(around.clone())) else { return };
        let (Some(r3), Some(r4)) = (r3.get(around), r4.get(columns)) else { return };
        let near = r1.iter().zip(r2.windows(3)).zip(r3.windows(3).zip(r4));
        for (x, ((n1, r2), (r3, n4))) in (from.max(1)..).zip(near) {
            let (&[a, n2, c], &[b, n3, d]) = (r2, r3) else { continue };
            let [n0, n5] = [r0, r5].map(|row| row.get(usize::from(x)).copied().unwrap_or(0));
            let near = [n0, *n1, n2, n3, *n4, n5];
            if self.is_edge(near.map(i32::from), [a, b, c, d]) {
                let far = [Side::Above, Side::Below].map(|side| self.column_stretch(x, side));
                self.keep(label, Crossing::new(Axis::Column, (x, self.y), near, far));
            }
        }
    }

    /// The stretch in column `x`, as far as its levels are those of an even surface and its rows are there.
    fn column_stretch(&self, x: u16, side: Side) -> Stretch {
        let row = usize::from(self.y - self.first);
        let above = self.rows.get(..=row).unwrap_or(&[]).iter().rev();
        let below = self.rows.get(row + usize::from(2 * REACH - 1)..).unwrap_or(&[]).iter();
        let mut levels = [0; FAR_ROWS];
        let mut len = 0;
        let mut add = |row: &&[u8]| {
            let level = row.get(usize::from(x)).copied().unwrap_or(0);
            let [first, ..] = levels;
            let flat = len == 0 || i32::from(level.abs_diff(first)) < self.min_step;
            if flat && let Some(slot) = levels.get_mut(len) {
                *slot = level;
                len += 1;
            }
            flat
        };
        match side {
            Side::Above => above.take(usize::from(self.y - REACH + 1).min(FAR_ROWS)).all(&mut add),
            Side::Below => {
                let there = self.pushed.saturating_sub(self.y + REACH - 1);
                below.take(usize::from(there).min(FAR_ROWS)).all(&mut add)
            }
        };
        let levels = levels.get(..stretch_length(len)).unwrap_or(&[]);
        Stretch::new(if tells_light(levels.first(), levels.last()) {
            levels
        } else {
            levels.get(..1).unwrap_or(&[])
        })
    }

    /// Whether the levels change enough along a crossing's axis, and across it not clearly more: then the other axis is
    /// the better one.
    fn is_edge(&self, near: [i32; NEAR], across: [u8; 4]) -> bool {
        let difference = |[a, b, c, d]: [i32; 4]| (c + d - a - b).abs();
        let [_, a, b, c, d, _] = near;
        let along = difference([a, b, c, d]);
        along >= self.min_step && 4 * difference(across.map(i32::from)) <= MAX_ACROSS * along
    }

    fn keep(&mut self, label: u16, crossing: Crossing) {
        loop {
            let Some(outline) = self.outlines.get_mut(label).filter(|o| !o.lossy) else { return };
            if self.pool.push(&mut outline.crossings, crossing) {
                return self.bound_cut(label);
            }
            // A target that the frame cuts is worth less than a whole one.
            if let Some(cut) = self.outlines.largest(|o| o.cut) {
                self.give_up(cut);
                continue;
            }
            self.dropped.crossings = self.dropped.crossings.saturating_add(1);
            // The outline with the most crossings pays: one large piece of clutter, not many small targets.
            match self.outlines.largest(|_| true) {
                Some(largest) => self.give_up(largest),
                None => return self.give_up(label),
            }
        }
    }
}

/// Levels from either end of the scale that noise clips, grey levels.
const END: u8 = 4;

/// Where a stretch of a crossing on a column lies.
#[derive(Clone, Copy)]
enum Side {
    Above,
    Below,
}

/// Most rows on either side for a stretch on a column.
const FAR_ROWS: usize = 4;

/// Whether the scale does not end within a stretch, of which these are the nearest and the farthest level: there only the
/// nearest pixel tells the light.
fn tells_light(nearest: Option<&u8>, farthest: Option<&u8>) -> bool {
    let clipped = |level: Option<&u8>| level.is_some_and(|level| !(END..=255 - END).contains(level));
    clipped(nearest) || !clipped(farthest)
}

/// Pixels of `row` from column `x` on.
fn from_column<const N: usize>(row: &[u8], x: u16) -> Option<&[u8; N]> {
    row.get(usize::from(x)..)?.first_chunk()
}

/// First and one past the last column of a dark run.
type Run = (u16, u16);

fn run(list: &[Transition], i: usize) -> Option<Run> {
    match list.get(2 * i..2 * i + 2) {
        Some([first, second]) => Some((first.x, second.x)),
        _ => None,
    }
}

/// Whether `run` exists and nothing of `other` touches it or lies left of it.
fn lies_left(run: Option<Run>, other: Option<Run>) -> bool {
    run.is_some_and(|run| other.is_none_or(|other| run.1 < other.0))
}

/// Whether `next`, which lies right of all that was linked, touches `run`.
fn touches(next: Option<Run>, run: Option<Run>) -> bool {
    next.is_some_and(|next| run.is_some_and(|run| next.0 <= run.1))
}
