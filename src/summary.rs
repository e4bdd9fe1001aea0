//! The account of a finished frame.

use crate::reject::{Dropped, Rejects};

/// What a frame came to, apart from its targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Summary {
    /// Width of the frame, px.
    pub width: u16,
    /// Height of the frame, px.
    pub height: u16,
    /// Targets handed out.
    pub targets: u32,
    /// Candidates that are no targets, by cause.
    pub rejected: Rejects,
    /// What full buffers cost.
    pub dropped: Dropped,
}
