//! What the firmware is given to measure, and how. The desktop compiles this file, too.
//!
//! 32-bit little-endian words: [`MAGIC`], the number of frames; for each frame its width and height, its
//! bound of the work ([`Settings::px_per_run`]), its effort ([`FULL`] or [`QUICK`]), how it is searched
//! ([`WHOLE`] or the number of its regions; these, four words each: first and last row, first and last column), then
//! [`SAME_PIXELS`], or [`OWN_PIXELS`] and its pixels, row by row without gaps, and [`WHOLE`] or [`WITH_RUNS`]. With runs, for each row: their number and for each the
//! first column, and the one after the last in the upper half. Widths are multiples of 4, so that every row starts at a word.

use concentric::report::Detail;
use concentric::{Compensation, Settings, Storage, TargetSpec};

/// "CONB": frames as this page says.
pub const MAGIC: u32 = u32::from_le_bytes(*b"CONB");
/// The effort for each target.
pub const FULL: u32 = 0;
pub const QUICK: u32 = 1;
/// In place of the number of regions: the whole frame is searched; after the pixels: no runs.
pub const WHOLE: u32 = u32::MAX;
/// Its pixels are those of the frame before, or follow.
pub const SAME_PIXELS: u32 = 0;
pub const OWN_PIXELS: u32 = 1;
/// Runs follow.
pub const WITH_RUNS: u32 = 1;
/// Most regions of a frame, and most runs of a row.
pub const MOST: usize = 64;
/// The least contrast that the runs were found with, grey levels.
pub const CONTRAST: u8 = 10;
/// Most targets in a report.
pub const MAX_TARGETS: usize = 64;
/// Detail of the reports.
pub const DETAIL: Detail = Detail::Full;

/// Storage of frames up to 320 px wide: what sixty targets need (20 outlines, 864 crossings), and a tenth more.
pub type Small = Storage<320, 24, 952>;
/// Storage of frames up to 640 px wide: the same (21 outlines, 1726 crossings).
pub type Medium = Storage<640, 24, 1900>;
/// Storage of frames up to 1280 px wide: the same (25 outlines, 3482 crossings).
pub type Large = Storage<1280, 28, 3830>;

/// Any concentric circles, and the exact centre.
pub const SETTINGS: Settings = Settings::new(TargetSpec::any()).compensation(Compensation::Exact);
