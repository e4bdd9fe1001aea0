//! What callers can do wrong.

use core::fmt;

use super::{MAX_HEIGHT, MIN_SIZE};
#[cfg(doc)]
use crate::Compensation;

/// A frame that cannot be processed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameError {
    /// Width outside the limits of the library or the storage.
    Width {
        /// Width given, px.
        given: u16,
        /// Largest width that fits, px.
        max: u16,
    },
    /// Height outside the limits.
    Height {
        /// Height given, px.
        given: u16,
    },
    /// The frame was ended before its last row.
    TooFewRows {
        /// Rows given.
        given: u16,
        /// Rows announced.
        height: u16,
    },
    /// A region is empty, does not lie within the frame, or begins above the one before it.
    Region {
        /// Its number, from 0.
        at: usize,
    },
    /// Regions were given after the first row.
    LateRegions {
        /// Rows given before.
        given: u16,
    },
    /// [`Compensation::Known`] without a camera in the settings.
    NoCamera,
    /// The camera's distortion shows places twice within the frame.
    Folded {
        /// Width, px.
        width: u16,
        /// Height, px.
        height: u16,
    },
    /// The number of pixels is not that of the size.
    Pixels {
        /// Pixels given.
        given: usize,
        /// Width, px.
        width: u16,
        /// Height, px.
        height: u16,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Width { given, max } => {
                write!(f, "frame width of {given} px is outside {MIN_SIZE}..={max}")
            }
            Self::Height { given } => {
                write!(f, "frame height of {given} px is outside {MIN_SIZE}..={MAX_HEIGHT}")
            }
            Self::TooFewRows { given, height } => {
                write!(f, "frame ended after {given} of {height} rows")
            }
            Self::Region { at } => write!(
                f,
                "region {at} must not be empty, must lie within the frame, and must not begin above the one before it"
            ),
            Self::LateRegions { given } => {
                write!(f, "regions after {given} rows: give them before the first")
            }
            Self::NoCamera => {
                write!(f, "compensation `Known` needs a camera in the settings (feature `camera`)")
            }
            Self::Folded { width, height } => write!(
                f,
                "camera: the distortion folds the image within a frame of {width} x {height}: smaller coefficients, or \
                 longer focal lengths, or a smaller frame"
            ),
            Self::Pixels { given, width, height } => {
                write!(f, "{given} pixels given for a frame of {width} x {height}")
            }
        }
    }
}

impl core::error::Error for FrameError {}

/// A row that cannot be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RowError {
    /// Not as long as the frame is wide.
    Length {
        /// Pixels given.
        given: usize,
        /// Width of the frame, px.
        width: u16,
    },
    /// The frame has all its rows.
    TooMany {
        /// Height of the frame, px.
        height: u16,
    },
    /// A run is empty, ends beyond the frame, or does not lie right of the one before with a light pixel between.
    Run {
        /// Its number, from 0.
        at: usize,
    },
    /// Runs with some rows of the frame and not with others, or with regions.
    Mixed,
    /// Its pixels are needed.
    Needed {
        /// Number of the row, from 0.
        row: u16,
    },
}

impl fmt::Display for RowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { given, width } => {
                write!(f, "row of {given} pixels in a frame that is {width} px wide")
            }
            Self::TooMany { height } => write!(f, "row after the last of {height}"),
            Self::Run { at } => write!(
                f,
                "run {at} must not be empty, must lie within the row, and right of the one before with a light pixel between"
            ),
            Self::Mixed => write!(f, "all rows of a frame come with their runs, or none; with regions none"),
            Self::Needed { row } => write!(f, "the pixels of row {row} are needed"),
        }
    }
}

impl core::error::Error for RowError {}
