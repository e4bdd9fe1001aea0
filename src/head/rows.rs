//! Rows from a sensor into the detector, targets into the report.

use crate::region::Region;
use crate::scan::Run;
use crate::{Detector, FrameError, Scan, Summary};

use super::{HeadError, Results};

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

    /// The dark runs of the row that was read last, where logic beside the processor finds them: in all rows of a frame or in
    /// none.
    fn runs(&self) -> Option<Runs<'_>> {
        None
    }
}

/// The dark runs of a row, as [`Scan::push_row_with_runs`] takes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Runs<'r> {
    /// From left to right.
    pub runs: &'r [Run],
    /// No difference of grey levels below this was taken for an edge.
    pub min_contrast: u8,
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

/// Takes one frame from `source` and collects its targets in `results`; `row` must hold a row of it. Only where targets are
/// expected is it searched if the tracker says so and the source gives no runs. `between` is called after every row, with time to
/// spare until the next one.
///
/// # Errors
/// `Source`, `Frame` or `Row` of [`HeadError`]. The detector is ready for the next frame.
pub fn measure<S: RowSource, L, const N: usize>(
    detector: &mut Detector<'_>,
    source: &mut S,
    row: &mut [u8],
    results: &mut Results<N>,
    mut between: impl FnMut(),
) -> Result<Summary, HeadError<S::Error, L>> {
    let start = source.start().map_err(HeadError::Source)?;
    results.begin(start.seq);
    let row = start.row(row)?;
    let regions = results.tracker.regions(start.width, start.height);
    let mut scan = detector.begin(start.width, start.height).map_err(HeadError::Frame)?;
    for y in 0..start.height {
        source.read_row(row).map_err(HeadError::Source)?;
        let runs = source.runs();
        if y == 0 {
            scan = limit(scan, regions.as_deref().filter(|_| runs.is_none()))?;
        }
        push(&mut scan, row, runs, results)?;
        between();
    }
    finish(scan, results)
}

/// The search of only these regions, if any.
pub(super) fn limit<'d, 's, S, L>(
    scan: Scan<'d, 's>,
    regions: Option<&'d [Region]>,
) -> Result<Scan<'d, 's>, HeadError<S, L>> {
    match regions {
        Some(regions) => scan.within(regions).map_err(HeadError::Frame),
        None => Ok(scan),
    }
}

/// The next row, and what it completes.
pub(super) fn push<S, L, const N: usize>(
    scan: &mut Scan<'_, '_>,
    row: &[u8],
    runs: Option<Runs<'_>>,
    results: &mut Results<N>,
) -> Result<(), HeadError<S, L>> {
    let targets = match runs {
        Some(Runs { runs, min_contrast }) => scan.push_row_with_runs(row, runs, min_contrast),
        None => scan.push_row(row),
    };
    results.take(targets.map_err(HeadError::Row)?);
    Ok(())
}

/// The end of a frame, and its last targets.
pub(super) fn finish<S, L, const N: usize>(
    scan: Scan<'_, '_>,
    results: &mut Results<N>,
) -> Result<Summary, HeadError<S, L>> {
    let mut rest = scan.finish().map_err(HeadError::Frame)?;
    results.take(rest.by_ref());
    Ok(rest.summary())
}
