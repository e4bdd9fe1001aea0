//! The thresholds of a strip's cells from the extremes about them.

use super::super::kernel::{self, Best, Bytes as _, MOST, ONES};
use super::{Extremes, NOTHING, Strip};
use crate::settings::Polarity;

/// Share of the least contrast by which noise may put flat surroundings on the wrong side of a threshold.
const DOUBT: u8 = 4;

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
/// side where it is; all for four cells. What is so near to it that noise may have put it on either side is taken for the paper of
/// `targets`.
pub(super) fn thresholds(held: u32, [low, high]: Extremes, contrast: u8, targets: Polarity) -> u32 {
    let doubt = u32::from(contrast / DOUBT) * ONES;
    let contrast = u32::from(contrast) * ONES;
    // All sums and differences stay within their bytes.
    let middle = (low + high + ONES) >> 1 & MOST;
    let distance = kernel::max((middle >> 3) & (0x0f * ONES), (contrast >> 1) & MOST);
    let above = middle + distance;
    let above = kernel::select(kernel::spread(above), MOST, above & MOST);
    let (up, down) = (kernel::max(held, above), kernel::min(held, Best::less(middle, distance)));
    let is_light = match targets {
        Polarity::Dark => kernel::at_least(middle, Best::less(held, doubt)),
        Polarity::Light => kernel::at_least(Best::less(middle, doubt), held),
    };
    let kept = kernel::select(is_light, down, up);
    kernel::select(kernel::at_least(high - low, contrast), middle, kept)
}
