//! The same with a sensor that is awaited. Needs no executor of its own; any will do.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

use super::rows::{Runs, finish, limit, push};
use super::{FrameStart, Head, HeadError, Line, Results};
use crate::{Detector, Summary};

/// [`head::RowSource`](super::RowSource), awaited.
#[expect(async_fn_in_trait, reason = "a head is one task: its futures need not move between threads")]
pub trait RowSource {
    /// What can go wrong with the sensor.
    type Error;

    /// Waits for the start of the next frame.
    ///
    /// # Errors
    /// Those of the sensor.
    async fn start(&mut self) -> Result<FrameStart, Self::Error>;

    /// Fills `row`, as long as the frame is wide, with the next row, top down.
    ///
    /// # Errors
    /// Those of the sensor; the frame is then given up.
    async fn read_row(&mut self, row: &mut [u8]) -> Result<(), Self::Error>;

    /// As [`head::RowSource::runs`](super::RowSource::runs).
    fn runs(&self) -> Option<Runs<'_>> {
        None
    }
}

/// [`head::measure`](super::measure), awaited.
///
/// # Errors
/// As there.
pub async fn measure<S: RowSource, L, const N: usize>(
    detector: &mut Detector<'_>,
    source: &mut S,
    row: &mut [u8],
    results: &mut Results<N>,
    mut between: impl FnMut(),
) -> Result<Summary, HeadError<S::Error, L>> {
    let start = source.start().await.map_err(HeadError::Source)?;
    results.begin(start.seq);
    let row = start.row(row)?;
    let regions = results.tracker.regions(start.width, start.height);
    let mut scan = detector.begin(start.width, start.height).map_err(HeadError::Frame)?;
    for y in 0..start.height {
        source.read_row(row).await.map_err(HeadError::Source)?;
        let runs = source.runs();
        if y == 0 {
            scan = limit(scan, regions.as_deref().filter(|_| runs.is_none()))?;
        }
        push(&mut scan, row, runs, results)?;
        between();
    }
    finish(scan, results)
}

impl<L: Line, S: OutputPin, T: InputPin, D: DelayNs> Head<'_, L, S, T, D> {
    /// [`frame`](Self::frame) with an awaited sensor. It does not wait for the trigger, because that would block the
    /// executor: await it before.
    ///
    /// # Errors
    /// As there.
    pub async fn frame_async<R: RowSource, const N: usize>(
        &mut self,
        detector: &mut Detector<'_>,
        source: &mut R,
        row: &mut [u8],
        results: &mut Results<N>,
    ) -> Result<Summary, HeadError<R::Error, L::Error>> {
        self.serve(detector, results).map_err(HeadError::Line)?;
        self.exposure.light_on().map_err(|_| HeadError::Strobe)?;
        let mut line = Ok(());
        let wire = &mut self.wire;
        let summary = measure(detector, source, row, results, || wire.move_bytes(&mut line)).await;
        self.after(summary, results, line)
    }
}
