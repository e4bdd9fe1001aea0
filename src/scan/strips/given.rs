//! Dark pixels from elsewhere: the runs that the logic beside the processor has found.
//!
//! The words of a strip are then the dark pixels of eight rows, one bit each: those of the block in work and of the one below.

use super::{END, STRIP, Strips};
use crate::scan::rows::BLOCK_ROWS;
use crate::scan::runs::Budget;
use crate::scan::{Run, RunError};

/// Rows that wait.
const ROWS: usize = 2 * BLOCK_ROWS;

impl Strips<'_> {
    /// The first run that is empty, ends beyond the frame or does not lie right of the one before it.
    pub fn check(runs: &[Run], width: u16) -> Result<(), RunError> {
        let mut free = 0;
        for (at, run) in runs.iter().enumerate() {
            if run.start < free || run.start >= run.end || run.end > width {
                return Err(RunError { at });
            }
            // A light pixel after it.
            free = run.end + 1;
        }
        Ok(())
    }

    /// Takes the runs of row `y`, which were checked; no edge has less contrast than `min_contrast`.
    pub fn take_runs(&mut self, y: u16, runs: &[Run], min_contrast: u8) {
        self.given = true;
        self.noise.contrast = (min_contrast / 2).max(1);
        let word = usize::from(y) % ROWS;
        let strips = self.all_mut();
        for strip in strips.iter_mut() {
            strip[word] = 0;
        }
        for run in runs {
            let [first, last] = [run.start, run.end - 1].map(usize::from);
            let touched = strips.get_mut(first / STRIP..=last / STRIP).unwrap_or_default();
            let (mut from, to) = (!0 << (first % STRIP), !0 >> (STRIP - 1 - last % STRIP));
            if let Some((end, before)) = touched.split_last_mut() {
                for strip in before {
                    strip[word] |= from;
                    from = !0;
                }
                end[word] |= from & to;
            }
        }
    }

    /// Counts a block whose rows are all there.
    pub fn count_block(&mut self) {
        self.blocks += 1;
    }

    /// Lists the strips of the block above the newest in which a row changes sides, but for those that are too busy for the
    /// budget. Returns how many runs were dropped with them.
    pub(super) fn resolve_given(&mut self, budget: &mut Budget) -> u32 {
        let mut dropped = 0;
        self.dark = usize::from(self.blocks) % 2 * BLOCK_ROWS;
        let (mut side, mut last) = (Some(0), END);
        self.first = END;
        for i in 0..self.count {
            let Some(dark) = self.get(i).and_then(|strip| strip.get(self.dark..)?.first_chunk()).copied()
            else {
                break;
            };
            if let Some(runs) = budget.take_strip(dark) {
                dropped += runs;
                continue;
            }
            let [a, b, c, d] = dark;
            // All on one side, or on both.
            let here = (a == b && a == c && a == d && (a == 0 || a == !0)).then_some(a);
            if here.is_none() || here != side {
                self.follow(last, i as u32);
                (last, side) = (i as u32, here);
            }
        }
        dropped
    }
}

#[cfg(test)]
mod tests;
