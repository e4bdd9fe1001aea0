//! Joins the transitions of a row to those of the row above.
//!
//! Dark runs are connected when they touch, corners included; light runs when they share a side. Between two rows an
//! outline goes on (a transition has one above it), begins (two neighbouring transitions have none above) or ends (two
//! neighbouring transitions have none below); an outline whose ends have all met is closed. The work is proportional
//! to the number of transitions, except that joined outlines are renamed once a row.

use super::crossings::{Crossing, CrossingList, Pool};
use super::outlines::{NONE, Outline, Outlines};
use super::rows::Rows;
use super::runs::{Budget, OF_CROSSING, Transition};
use super::window::Window;
use crate::reject::Dropped;
use crate::settings::limits;

/// Steepest step from row to row, px, at which the crossing on the row is kept: beyond it the one on the column is the
/// better one.
const MAX_ROW_STEP: u16 = 2;

pub(crate) struct Linker<'a, 's> {
    window: Window<'a>,
    outlines: &'a mut Outlines<'s>,
    pool: &'a mut Pool<'s>,
    dropped: &'a mut Dropped,
    pub budget: &'a mut Budget,
}

impl<'a, 's> Linker<'a, 's> {
    /// For the block of rows from `first` on, where the smallest contrast of an edge is `min_contrast`.
    pub fn new(
        rows: &'a Rows<'s>,
        outlines: &'a mut Outlines<'s>,
        pool: &'a mut Pool<'s>,
        (dropped, budget): (&'a mut Dropped, &'a mut Budget),
        (first, min_contrast): (u16, u8),
    ) -> Self {
        Self { window: Window::new(rows, first, min_contrast), outlines, pool, dropped, budget }
    }

    /// Gives every transition of `current`, in row `y` of the block or in the one below the frame, its outline; `previous` is
    /// the row above.
    pub fn link_row(&mut self, y: u16, previous: &[Transition], current: &mut [Transition]) {
        self.window.move_to(y);
        self.link(previous, current);
    }

    #[inline(never)]
    fn link(&mut self, previous: &[Transition], current: &mut [Transition]) {
        let (mut i, mut j) = (0, 0);
        let (mut above, mut here) = (run(previous, 0), run(current, 0));
        // Where the run before `here` ends.
        let mut last = 0;
        loop {
            if above.1 < here.0 {
                self.end(previous, 2 * i);
                i += 1;
                above = run(previous, i);
            } else if here.1 < above.0 {
                self.begin(current, 2 * j);
                j += 1;
                (last, here) = (here.1, run(current, j));
            } else if here == NO_RUN {
                // Then there is none above either.
                break;
            } else {
                self.proceed(previous.get(2 * i), current.get_mut(2 * j), DARKER, [last, here.1]);
                // A set of connected runs, to its right end.
                loop {
                    let next_above = run(previous, i + 1);
                    if next_above.0 <= here.1 {
                        self.end(previous, 2 * i + 1);
                        (i, above) = (i + 1, next_above);
                        continue;
                    }
                    let next_here = run(current, j + 1);
                    if next_here.0 <= above.1 {
                        self.begin(current, 2 * j + 1);
                        (j, here) = (j + 1, next_here);
                        continue;
                    }
                    let beside = [here.0, next_here.0];
                    self.proceed(previous.get(2 * i + 1), current.get_mut(2 * j + 1), LIGHTER, beside);
                    (i, above, j) = (i + 1, next_above, j + 1);
                    (last, here) = (here.1, next_here);
                    break;
                }
            }
        }
        if self.outlines.any_joined() {
            for transition in current {
                transition.label = self.outlines.root(transition.label);
            }
            self.outlines.free_joined();
        }
    }

    /// An outline goes on from the transition `above` to the one `here`, which has others at the columns `beside`.
    #[inline(never)]
    fn proceed(
        &mut self,
        above: Option<&Transition>,
        here: Option<&mut Transition>,
        sign: i32,
        beside: [u16; 2],
    ) {
        let (Some(above), Some(here)) = (above, here) else { return };
        let joined = above.label != NONE && self.outlines.any_joined();
        let label = if joined { self.outlines.root(above.label) } else { above.label };
        here.label = label;
        let (from, x, y) = (above.x, here.x, self.window.y);
        let Some(outline) = self.outlines.get_mut(label) else { return };
        // Of what lost a part only the box is of use.
        if outline.lossy {
            return outline.reach(x, y);
        }
        outline.add_transition(sign, x, y);
        self.budget.take(OF_CROSSING);
        if x == 0 || x >= self.window.width {
            self.mark_cut(label);
        } else if from.abs_diff(x) <= MAX_ROW_STEP
            && let Some(crossing) = self.window.row_crossing(x, beside)
        {
            self.keep(label, crossing);
        }
        if from != x {
            self.keep_column_crossings(label, from.min(x), from.max(x));
        }
    }

    /// An outline begins with the transitions `at` and `at + 1`.
    #[inline(never)]
    fn begin(&mut self, current: &mut [Transition], at: usize) {
        let (before, from) = current.split_at_mut_checked(at).unwrap_or_default();
        let [first, second, ..] = from else { return };
        (first.label, second.label) = (NONE, NONE);
        let (keeping, inside) = (self.outlines.keeping(), || self.is_inside([*first, *second], before));
        if !self.budget.admits(keeping, inside) {
            self.dropped.crossings = self.dropped.crossings.saturating_add(1);
            return;
        }
        let label = self.outlines.open(first.x, self.window.y);
        if label == NONE {
            self.dropped.outlines = self.dropped.outlines.saturating_add(1);
            return;
        }
        (first.label, second.label) = (label, label);
        let sign = if at.is_multiple_of(2) { DARKER } else { LIGHTER };
        self.add_transition(label, sign, first.x);
        self.add_transition(label, -sign, second.x);
        self.keep_column_crossings(label, first.x, second.x);
    }

    /// Whether an outline that begins with the transitions `new` lies in one that keeps its crossings, where those `before` are on
    /// the left.
    fn is_inside(&self, [first, second]: [Transition; 2], before: &[Transition]) -> bool {
        let around = before.last().and_then(|transition| self.outlines.get(transition.label));
        around.is_some_and(|o| !o.lossy && o.left < first.x && o.right > second.x)
    }

    /// The transitions `at` and `at + 1` of the row above meet.
    #[inline(never)]
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
        if self.window.y == self.window.height {
            self.mark_cut(label);
        }
        if !self.outlines.get(label).is_some_and(|outline| outline.closes(ends) && outline.is_small()) {
            self.keep_column_crossings(label, first.x, second.x);
        }
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
        self.outlines.join(a, b, self.window.y);
        let spoiled = self.outlines.get(a).is_some_and(|o| o.lossy);
        if spoiled {
            self.free_crossings(a);
        }
        self.bound_cut(a);
    }

    #[inline(always)]
    fn add_transition(&mut self, label: u16, sign: i32, x: u16) {
        let cut = x == 0 || x >= self.window.width || self.window.y == 0;
        if let Some(outline) = self.outlines.get_mut(label) {
            outline.add_transition(sign, x, self.window.y);
            if cut {
                self.mark_cut(label);
            }
        }
    }

    #[inline(never)]
    fn mark_cut(&mut self, label: u16) {
        if let Some(outline) = self.outlines.get_mut(label) {
            outline.cut = true;
        }
        self.bound_cut(label);
    }

    /// An outline that the frame cuts gives up when it has many crossings: it is more often background than a target. `false` if
    /// it does.
    #[inline(never)]
    fn bound_cut(&mut self, label: u16) -> bool {
        let most = self.pool.capacity() / limits::CUT_SHARE;
        let too_many = |outline: &Outline| outline.cut && usize::from(outline.crossings.len()) > most;
        let gives_up = self.outlines.get(label).is_some_and(too_many);
        if gives_up {
            self.give_up(label);
        }
        !gives_up
    }

    #[inline(never)]
    fn give_up(&mut self, label: u16) {
        if let Some(crossings) = self.outlines.lose(label) {
            self.pool.free(crossings);
        }
    }

    /// Gives an outline up for the others.
    #[inline(never)]
    fn drop_crossings(&mut self, label: u16) {
        self.dropped.crossings = self.dropped.crossings.saturating_add(1);
        self.give_up(label);
    }

    #[inline(never)]
    fn free_crossings(&mut self, label: u16) {
        if let Some(outline) = self.outlines.get_mut(label) {
            self.pool.free(&mut outline.crossings);
        }
    }

    /// Keeps the crossings between the row above and this one in the columns `from..to`, as long as the outline keeps any.
    #[inline(never)]
    fn keep_column_crossings(&mut self, label: u16, from: u16, to: u16) {
        if self.outlines.get(label).is_none_or(|outline| outline.lossy) {
            return;
        }
        let columns = self.window.columns(from, to);
        if columns.is_empty() {
            return;
        }
        let pieces = OF_CROSSING * columns.len();
        if !self.budget.take_if_spare(pieces) {
            return self.drop_crossings(label);
        }
        for x in columns {
            if let Some(crossing) = self.window.column_crossing(x)
                && !self.keep(label, crossing)
            {
                return;
            }
        }
    }

    /// Keeps a crossing of an outline of which nothing is lost. `false` if that loses them all.
    #[inline(always)]
    fn keep(&mut self, label: u16, crossing: Crossing) -> bool {
        let Some(outline) = self.outlines.get_mut(label) else { return false };
        let is_cut = outline.cut;
        let slot = match self.pool.push(&mut outline.crossings) {
            Some(slot) => slot,
            None => match self.push_in_full(label) {
                Some(slot) => slot,
                None => return false,
            },
        };
        *slot = crossing;
        !is_cut || self.bound_cut(label)
    }

    /// A slot for a crossing of outline `label` where the pool is full. `None` if that gives up for it.
    #[cold]
    #[inline(never)]
    fn push_in_full(&mut self, label: u16) -> Option<&mut Crossing> {
        while let Some(outline) = self.outlines.get_mut(label).filter(|outline| !outline.lossy) {
            if !self.pool.is_full() {
                return self.pool.push(&mut outline.crossings);
            }
            self.make_room(label);
        }
        None
    }

    /// Gives up an outline for the crossings of outline `label`.
    fn make_room(&mut self, label: u16) {
        // A target that the frame cuts is worth less than a whole one.
        if let Some(cut) = self.outlines.largest(|o| o.cut) {
            return self.give_up(cut);
        }
        // The outline with the most crossings pays: one large piece of clutter, not many small targets.
        self.drop_crossings(self.outlines.largest(|_| true).unwrap_or(label));
    }
}

/// Signs of the transitions where a row turns dark and light.
const DARKER: i32 = -1;
const LIGHTER: i32 = 1;

/// First and one past the last column of a dark run.
type Run = (u16, u16);

/// Right of all runs.
const NO_RUN: Run = (u16::MAX, u16::MAX);

fn run(list: &[Transition], i: usize) -> Run {
    list.as_chunks().0.get(i).map_or(NO_RUN, |[first, second]| (first.x, second.x))
}
