//! What the firmware is given to measure, and how. The desktop compiles this file, too.
//!
//! 32-bit little-endian words: [`MAGIC`], the number of frames; for each frame its width and height, then its pixels, row
//! by row without gaps. Widths are multiples of 4, so that every row starts at a word.

use concentric::report::Detail;
use concentric::{Compensation, Settings, Storage, TargetSpec};

/// "CONB": frames as this page says.
pub const MAGIC: u32 = u32::from_le_bytes(*b"CONB");
/// Most targets in a report.
pub const MAX_TARGETS: usize = 64;
/// Detail of the reports.
pub const DETAIL: Detail = Detail::Full;

/// Storage of frames up to 320 px wide.
pub type Small = Storage<320, 64, 1000>;
/// Storage of frames up to 640 px wide.
pub type Medium = Storage<640, 128, 1800>;
/// Storage of frames up to 1280 px wide.
pub type Large = Storage<1280, 160, 3600>;

/// Any concentric circles, and the exact centre.
pub const SETTINGS: Settings = Settings::new(TargetSpec::any()).compensation(Compensation::Exact);
