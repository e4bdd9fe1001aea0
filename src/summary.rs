//! The account of a finished frame.

use crate::reject::{Dropped, Rejects};

/// Most that a frame needed of each buffer of the [`Storage`](crate::Storage) at a time. Where nothing was dropped, a
/// storage of this size is enough for the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Used {
    /// Outlines.
    pub outlines: u16,
    /// Crossings.
    pub crossings: u16,
}

/// What a frame came to, apart from its targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Summary {
    /// Width of the frame, px.
    pub width: u16,
    /// Height of the frame, px.
    pub height: u16,
    /// Only [regions](crate::Scan::within) of it were searched.
    pub limited: bool,
    /// Targets handed out.
    pub targets: u32,
    /// Candidates that are no targets, by cause.
    pub rejected: Rejects,
    /// What full buffers cost.
    pub dropped: Dropped,
    /// Broken outlines in which no arcs were looked for, because the frame had used up its searches (16 and one for 4096 px, at
    /// most 64) or most of its runs.
    pub unsearched: u32,
    /// What it needed of the buffers. Not part of the report.
    pub used: Used,
}
