//! Rows from a sensor into the detector, targets into the report.

use crate::report::Report;
use crate::{Detector, FrameError, Summary};

use super::HeadError;

/// A sensor that delivers frames row by row, blocking.
pub trait RowSource {
    /// What can go wrong with the sensor.
    type Error;

    /// Waits for the start of the next frame.
    ///
    /// # Errors
    /// Those of the sensor.
    fn start(&mut self) -> Result<FrameStart, Self::Error>;

    /// Fills `row`, as long as the frame is wide, with the next row, top down.
    ///
    /// # Errors
    /// Those of the sensor; the frame is then given up.
    fn read_row(&mut self, row: &mut [u8]) -> Result<(), Self::Error>;
}

/// The start of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameStart {
    /// Number of the frame: counts every frame of the sensor, so that the receiver sees gaps.
    pub seq: u32,
    /// Width, px.
    pub width: u16,
    /// Height, px.
    pub height: u16,
}

impl FrameStart {
    /// The part of `row` that holds a row of the frame.
    pub(super) fn row<'r, S, L>(&self, row: &'r mut [u8]) -> Result<&'r mut [u8], HeadError<S, L>> {
        let max = row.len().min(usize::from(u16::MAX)) as u16;
        let too_wide = FrameError::Width { given: self.width, max };
        row.get_mut(..usize::from(self.width)).ok_or(HeadError::Frame(too_wide))
    }
}

/// Takes one frame from `source` and collects its targets in `report`; `row` must hold a row of it. `between` is called
/// after every row, with time to spare until the next one.
///
/// # Errors
/// `Source`, `Frame` or `Row` of [`HeadError`]. The detector is ready for the next frame.
pub fn measure<S: RowSource, L, const N: usize>(
    detector: &mut Detector<'_>,
    source: &mut S,
    row: &mut [u8],
    report: &mut Report<N>,
    mut between: impl FnMut(),
) -> Result<Summary, HeadError<S::Error, L>> {
    let start = source.start().map_err(HeadError::Source)?;
    report.begin(start.seq);
    let row = start.row(row)?;
    let mut scan = detector.begin(start.width, start.height).map_err(HeadError::Frame)?;
    for _ in 0..start.height {
        source.read_row(row).map_err(HeadError::Source)?;
        for target in scan.push_row(row).map_err(HeadError::Row)? {
            report.push(&target);
        }
        between();
    }
    let mut rest = scan.finish().map_err(HeadError::Frame)?;
    for target in rest.by_ref() {
        report.push(&target);
    }
    Ok(rest.summary())
}
