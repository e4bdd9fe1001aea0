//! The thresholds of a strip's cells from the extremes about them.

use super::super::kernel::{self, MOST, ONES, TOP};
use super::{Extremes, NOTHING, Strip};

/// The extremes of three blocks.
pub(super) fn column(strip: &Strip) -> Extremes {
    let [a, b, c, d, e, f, ..] = *strip;
    [kernel::min(a, kernel::min(b, c)), kernel::max(d, kernel::max(e, f))]
}

/// The columns of the strips left of a strip, of itself, and right of it.
pub(super) struct Columns {
    pub extremes: [Extremes; 3],
    /// The strip after it.
    pub at: usize,
}

impl Columns {
    pub const NONE: Self = Self { extremes: [NOTHING; 3], at: usize::MAX };

    /// For each cell the extremes of the three columns about it.
    pub fn about(&self) -> Extremes {
        let [[l0, h0], [l1, h1], [l2, h2]] = self.extremes;
        let beside = |left: u32, here: u32, right: u32| (here << 8 | left >> 24, here >> 8 | right << 24);
        let ((la, lb), (ha, hb)) = (beside(l0, l1, l2), beside(h0, h1, h2));
        [kernel::min(l1, kernel::min(la, lb)), kernel::max(h1, kernel::max(ha, hb))]
    }
}

/// The middle between `low` and `high`, or in flat surroundings the threshold `held`, kept at a distance from them on the
/// side where it is; all for four cells.
pub(super) fn thresholds(held: u32, low: u32, high: u32, contrast: u8) -> u32 {
    let contrast = u32::from(contrast) * ONES;
    // All sums and differences stay within their bytes.
    let middle = (low + high + ONES) >> 1 & MOST;
    let distance = kernel::max((middle >> 3) & (0x0f * ONES), (contrast >> 1) & MOST);
    let above = middle + distance;
    let above = kernel::select(kernel::spread(above), MOST, above & MOST);
    let below = (middle | TOP) - distance;
    let below = below & kernel::spread(below);
    let (up, down) = (kernel::max(held, above), kernel::min(held, below));
    let kept = kernel::select(kernel::at_least(middle, held), down, up);
    kernel::select(kernel::at_least(high - low, contrast), middle, kept)
}
