//! Rows in, closed outlines out.
//!
//! 1. [`rows`]: the last 12 rows are kept, because a vertical edge profile needs its neighbours above and below.
//! 2. [`strips`]: a threshold for each cell of 8 x 4 px from the local extremes, by the [`kernel`] that every pixel passes.
//! 3. [`runs`]: where the rows pass it ([`Transition`]s).
//! 4. [`link`]: transitions of successive rows are joined to outlines.
//! 5. [`outlines`]: table of those outlines with their exact moments; [`crossings`]: pool of their edge profiles.
//!
//! A region of either polarity and its outer outline are the same thing here: following outlines instead of pixels
//! labels dark and light regions at once, gives the moments of the *filled* shape, and says what lies in what.

#[cfg(any(test, feature = "self-test"))]
pub mod agree;
mod crossings;
pub(crate) mod kernel;
mod link;
mod moments;
mod noise;
mod outlines;
mod rows;
mod runs;
pub(crate) mod strips;
#[cfg(test)]
mod tests;
mod window;

pub(crate) use crossings::{Axis, Crossing, CrossingList, EdgePoint, NEAR, Pool, Stretch};
pub(crate) use moments::Moments;
pub(crate) use outlines::{NONE, Outline, Outlines, Seen};
pub(crate) use rows::{BLOCK_ROWS, KEPT_BLOCKS, Rows};
pub use runs::Run;
pub(crate) use runs::{RunError, Transition};
pub(crate) use strips::{STRIP, STRIP_WIDTHS};

use crate::region::Regions;
use crate::reject::Dropped;
use crate::settings::Settings;
use crate::storage::Buffers;
use link::Linker;
use runs::{Budget, TransitionList};
use strips::Strips;

/// The state of a frame on its way through the stages before the candidates.
#[derive(Debug)]
pub(crate) struct Scanner<'s> {
    rows: Rows<'s>,
    strips: Strips<'s>,
    previous: TransitionList<'s>,
    current: TransitionList<'s>,
    pub outlines: Outlines<'s>,
    pub pool: Pool<'s>,
    pub dropped: Dropped,
    pub budget: Budget,
    /// Rows whose transitions have been linked.
    pub linked: u16,
}

impl<'s> Scanner<'s> {
    pub fn new(buffers: Buffers<'s>) -> Self {
        Self {
            rows: Rows::new(buffers.rows),
            strips: Strips::new(buffers.strips),
            previous: TransitionList::new(buffers.previous),
            current: TransitionList::new(buffers.current),
            outlines: Outlines::new(buffers.outlines),
            pool: Pool::new(buffers.crossings),
            dropped: Dropped::default(),
            budget: Budget::NONE,
            linked: 0,
        }
    }

    /// Widest frame that fits.
    pub fn capacity(&self) -> usize {
        self.rows.capacity()
    }

    /// Width of the frame.
    pub fn width(&self) -> u16 {
        self.rows.width()
    }

    /// Height of the frame.
    pub fn height(&self) -> u16 {
        self.rows.height()
    }

    /// Rows taken so far.
    pub fn pushed(&self) -> u16 {
        self.rows.pushed()
    }

    /// Forgets everything and prepares for a frame of `width` <= `capacity()` as the settings want it.
    pub fn begin(&mut self, width: u16, height: u16, settings: &Settings) {
        self.rows.begin(width, height);
        self.strips.begin(width, settings.spec.polarity());
        self.previous.clear();
        self.current.clear();
        self.outlines.clear();
        self.pool.clear();
        self.dropped = Dropped::default();
        self.budget = Budget::new(width, settings.px_per_run);
        self.linked = 0;
    }

    /// Takes the next row. Whole blocks of rows are linked as soon as the block below them is known; outlines that
    /// closed are then in [`Outlines::take_closed`].
    pub fn push_row(&mut self, row: &[u8], regions: &mut Regions<'_>) {
        if regions.need(self.rows.pushed()) {
            self.rows.push(row);
        } else {
            self.rows.skip();
        }
        if self.rows.block_complete() {
            self.strips.measure(&self.rows, regions);
            self.link_block();
        }
    }

    /// Whether the rows of this frame come with their runs.
    pub fn runs_are_given(&self) -> bool {
        self.strips.are_given()
    }

    /// The same with the runs of the row, where no edge has less contrast than `min_contrast`.
    pub fn push_row_with_runs(&mut self, row: &[u8], runs: &[Run], min_contrast: u8) -> Result<(), RunError> {
        Strips::check(runs, self.rows.width())?;
        self.strips.take_runs(self.rows.pushed(), runs, min_contrast);
        self.rows.push(row);
        if self.rows.block_complete() {
            self.strips.count_block();
            self.link_block();
        }
        Ok(())
    }

    /// Links the rows that waited for a block below them, and closes what is open at the frame's lower border.
    pub fn finish(&mut self, regions: &mut Regions<'_>) {
        while self.linked < self.rows.height() {
            // The last block has nothing below it; what is there of it is measured again or for the first time.
            if self.strips.are_given() {
                self.strips.count_block();
            } else {
                self.strips.measure(&self.rows, regions);
            }
            self.link_block();
        }
        let below = self.rows.height();
        self.link_rows(below, below + 1);
    }

    /// Links the block of rows above the newest measured one.
    fn link_block(&mut self) {
        let first = self.linked;
        let Some(below) = self.strips.blocks().checked_sub(2) else { return };
        if below != first / BLOCK_ROWS as u16 {
            return;
        }
        self.budget.save(BLOCK_ROWS as u16);
        let dropped = self.strips.resolve(&self.rows, &mut self.budget);
        self.dropped.runs = self.dropped.runs.saturating_add(dropped);
        let last = (first + BLOCK_ROWS as u16).min(self.rows.height());
        self.link_rows(first, last);
    }

    /// Links the rows from `first` to before `last`; the one below the frame is light.
    fn link_rows(&mut self, first: u16, last: u16) {
        self.linked = last;
        if self.previous.as_slice().is_empty() && self.strips.all_light() {
            return;
        }
        let Self { rows, strips, outlines, pool, dropped, budget, .. } = self;
        let mut runs = 0;
        let mut linker = Linker::new(rows, outlines, pool, (dropped, budget), (first, strips.min_contrast()));
        for y in first..last {
            if y < rows.height() {
                runs += self.current.fill(strips, usize::from(y - first), rows.width(), linker.budget);
            } else {
                self.current.clear();
            }
            linker.link_row(y, self.previous.as_slice(), self.current.as_mut_slice());
            core::mem::swap(&mut self.previous, &mut self.current);
        }
        self.dropped.runs = self.dropped.runs.saturating_add(runs);
    }

    /// A slot for an outline that is part of another one. [`NONE`], and counted, when the table is full.
    pub fn open_outline(&mut self) -> u16 {
        let label = self.outlines.open_closed();
        if label == NONE {
            self.dropped.outlines = self.dropped.outlines.saturating_add(1);
        }
        label
    }

    /// Gives back an outline and those inside it.
    pub fn free(&mut self, mut label: u16) {
        while let Some(outline) = self.outlines.get_mut(label) {
            self.pool.free(&mut outline.crossings);
            let inner = core::mem::replace(&mut outline.inner, NONE);
            self.outlines.free(label);
            label = inner;
        }
    }

    /// Transitions of the last linked row, with the labels of their outlines.
    pub fn last_transitions(&self) -> &[Transition] {
        self.previous.as_slice()
    }
}
