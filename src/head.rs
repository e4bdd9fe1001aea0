//! The loop of a camera head: rows from a sensor, a light to switch, a serial line for the reports.
//!
//! The sensor is whatever implements [`RowSource`]; the light is an `embedded-hal` pin and the line an `embedded-io`
//! writer, so that this runs on any board. Needs the feature `hal`.

use core::fmt;

use crate::report::{EncodeError, Report};
use crate::{Detector, FrameError, RowError, Summary};
use embedded_hal::digital::OutputPin;
use embedded_io::Write;

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

/// Takes one frame from `source` and collects its targets in `report`; `row` must hold a row of it.
///
/// # Errors
/// [`HeadError`], except for `Report`, `Link` and `Strobe`. The detector is ready for the next frame.
pub fn measure<S: RowSource, L, const N: usize>(
    detector: &mut Detector<'_>,
    source: &mut S,
    row: &mut [u8],
    report: &mut Report<N>,
) -> Result<Summary, HeadError<S::Error, L>> {
    let FrameStart { seq, width, height } = source.start().map_err(HeadError::Source)?;
    report.begin(seq);
    let capacity = row.len().min(usize::from(u16::MAX)) as u16;
    let too_wide = FrameError::Width { given: width, max: capacity };
    let row = row.get_mut(..usize::from(width)).ok_or(HeadError::Frame(too_wide))?;
    let mut scan = detector.begin(width, height).map_err(HeadError::Frame)?;
    for _ in 0..height {
        source.read_row(row).map_err(HeadError::Source)?;
        for target in scan.push_row(row).map_err(HeadError::Row)? {
            report.push(&target);
        }
    }
    let mut rest = scan.finish().map_err(HeadError::Frame)?;
    for target in rest.by_ref() {
        report.push(&target);
    }
    Ok(rest.summary())
}

/// A head with a light and a line.
#[derive(Debug)]
pub struct Head<L, P> {
    link: L,
    strobe: P,
}

impl<L: Write, P: OutputPin> Head<L, P> {
    /// A head that sends its reports over `link` and drives `strobe` high while a frame is read. A board without a light
    /// gives a pin that does nothing.
    pub fn new(link: L, strobe: P) -> Self {
        Self { link, strobe }
    }

    /// Measures one frame and sends its report. `row` must hold a row, `bytes` the encoded report
    /// ([`max_len`](crate::report::max_len)). Blocks until the line has taken all bytes.
    ///
    /// # Errors
    /// [`HeadError`]. The light is off and the next frame can be measured.
    pub fn frame<S: RowSource, const N: usize>(
        &mut self,
        detector: &mut Detector<'_>,
        source: &mut S,
        report: &mut Report<N>,
        (row, bytes): (&mut [u8], &mut [u8]),
    ) -> Result<Summary, HeadError<S::Error, L::Error>> {
        self.strobe.set_high().map_err(|_| HeadError::Strobe)?;
        let summary = measure(detector, source, row, report);
        self.strobe.set_low().map_err(|_| HeadError::Strobe)?;
        let summary = summary?;
        let message = report.finish(&summary, bytes).map_err(HeadError::Report)?;
        self.link.write_all(message).map_err(HeadError::Link)?;
        self.link.flush().map_err(HeadError::Link)?;
        Ok(summary)
    }

    /// Gives line and pin back.
    pub fn release(self) -> (L, P) {
        (self.link, self.strobe)
    }
}

/// Why a frame was not measured or its report not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HeadError<S, L> {
    /// The sensor failed.
    Source(S),
    /// The frame's size does not fit, or it ended early.
    Frame(FrameError),
    /// A row does not fit.
    Row(RowError),
    /// The report does not fit in its buffer.
    Report(EncodeError),
    /// The line failed.
    Link(L),
    /// The light's pin failed.
    Strobe,
}

impl<S: fmt::Debug, L: fmt::Debug> fmt::Display for HeadError<S, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => write!(f, "sensor: {error:?}"),
            Self::Frame(error) => write!(f, "{error}"),
            Self::Row(error) => write!(f, "{error}"),
            Self::Report(error) => write!(f, "report: {error}"),
            Self::Link(error) => write!(f, "line: {error:?}"),
            Self::Strobe => write!(f, "the light's pin failed"),
        }
    }
}

impl<S: fmt::Debug, L: fmt::Debug> core::error::Error for HeadError<S, L> {}
