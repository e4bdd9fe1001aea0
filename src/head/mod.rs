//! The loop of a camera head: rows from a sensor, a trigger to wait for, a light to switch, a serial line for reports and
//! commands.
//!
//! The sensor is whatever implements [`RowSource`]; light and trigger are `embedded-hal` pins ([`Exposure`]) and the line
//! is `embedded-io` ([`Line`]), so that this runs on any board. Needs the feature `hal`.
//!
//! The head never waits for its line. Reports are encoded into a buffer, from which bytes leave between the rows of the
//! next frames, as many as the line takes at once. A report for which there is no room is given up as a whole and
//! counted; every later report has the count. [Commands](crate::report#commands) are read at the same moments, and carried
//! out between frames.
//!
//! ```
//! # use core::convert::Infallible;
//! use concentric::head::{Exposure, FrameStart, Head, Results, RowSource, SendOnly, buffer_len};
//! use concentric::report::{Detail, Format, Version};
//! use concentric::{Detector, Settings, Storage, TargetSpec};
//!
//! # struct Sensor(u32);
//! # impl RowSource for Sensor {
//! #     type Error = Infallible;
//! #     fn start(&mut self) -> Result<FrameStart, Infallible> {
//! #         self.0 += 1;
//! #         Ok(FrameStart { seq: self.0, width: 64, height: 48 })
//! #     }
//! #     fn read_row(&mut self, row: &mut [u8]) -> Result<(), Infallible> {
//! #         row.fill(200);
//! #         Ok(())
//! #     }
//! # }
//! # struct Uart;
//! # impl embedded_io::ErrorType for Uart { type Error = Infallible; }
//! # impl embedded_io::Write for Uart {
//! #     fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> { Ok(bytes.len()) }
//! #     fn flush(&mut self) -> Result<(), Infallible> { Ok(()) }
//! # }
//! # impl embedded_io::WriteReady for Uart {
//! #     fn write_ready(&mut self) -> Result<bool, Infallible> { Ok(true) }
//! # }
//! # let (mut sensor, uart) = (Sensor(0), Uart);
//! let mut storage = Storage::<64, 16, 1024>::new();
//! let mut detector = Detector::new(Settings::new(TargetSpec::any()), &mut storage);
//! let mut results = Results::<8>::new(Detail::Normal);
//! let mut row = [0; 64];
//! let mut buffer = [0; buffer_len(8, Detail::Normal)];
//! let mut head = Head::new(SendOnly(uart), Exposure::free_running(), Version::LIBRARY, &mut buffer);
//! for _ in 0..3 {
//!     let summary = head.frame(&mut detector, &mut sensor, &mut row, &mut results)?;
//!     assert_eq!(summary.targets, 0);
//! }
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

pub mod asynch;
mod exposure;
mod remote;
mod results;
mod rows;
mod wire;

use core::fmt;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};

use crate::log::log;
use crate::report::{
    ANSWER_MAX_LEN, Answer, Detail, EncodeError, Format, HELLO_MAX_LEN, HeadSettings, Hello, Report, Version,
    max_len, max_text_len,
};
use crate::{Detector, FrameError, RowError, Summary};

pub use exposure::{Absent, Exposure};
pub use results::Results;
pub use rows::{FrameStart, RowSource, Runs, measure};
pub use wire::{Line, SendOnly};

use exposure::Wait;
use remote::Changeable;
use wire::Wire;

/// Bytes of the buffer that reports leave free, so that a line that is too slow for them still gets its answers.
const RESERVE: usize = HELLO_MAX_LEN + ANSWER_MAX_LEN;

/// Bytes of buffer for one report of up to `targets` targets, in either format, and the answer to a command. A multiple lets
/// more reports wait where the line has breaks.
pub const fn buffer_len(targets: usize, detail: Detail) -> usize {
    let (binary, text) = (max_len(targets, detail), max_text_len(targets, detail));
    (if binary > text { binary } else { text }).saturating_add(RESERVE)
}

/// A camera head.
#[derive(Debug)]
pub struct Head<'b, L, S = Absent, T = Absent, D = Absent> {
    exposure: Exposure<S, T, D>,
    wire: Wire<'b, L>,
    firmware: Version,
    format: Format,
    hello_due: bool,
}

impl<'b, L: Line, S: OutputPin, T: InputPin, D: DelayNs> Head<'b, L, S, T, D> {
    /// A head with this light and trigger that sends its reports over `line`, the hello first. Reports wait in `buffer`
    /// ([`buffer_len`]) until the line takes them.
    pub fn new(line: L, exposure: Exposure<S, T, D>, firmware: Version, buffer: &'b mut [u8]) -> Self {
        Self { exposure, wire: Wire::new(line, buffer), firmware, format: Format::Binary, hello_due: true }
    }

    /// The format of the reports; a command can change it.
    pub fn set_format(&mut self, format: Format) {
        self.hello_due = format == Format::Binary;
        self.format = format;
    }

    /// Sends a hello before the next report.
    pub fn introduce(&mut self) {
        self.hello_due = true;
    }

    /// Waits for the trigger, measures a frame with the light on and hands its report to the line. `row` must hold a row.
    /// Commands that arrived by then are carried out first.
    ///
    /// # Errors
    /// [`HeadError`]. The light is off and the next frame can be measured. After `Line` the report is in the buffer, or
    /// given up and counted.
    pub fn frame<R: RowSource, const N: usize>(
        &mut self,
        detector: &mut Detector<'_>,
        source: &mut R,
        row: &mut [u8],
        results: &mut Results<N>,
    ) -> Result<Summary, HeadError<R::Error, L::Error>> {
        self.serve(detector, results).map_err(HeadError::Line)?;
        let (wire, mut line) = (&mut self.wire, Ok(()));
        match self.exposure.wait(|| wire.move_bytes(&mut line)) {
            Wait::Triggered => {}
            Wait::TimedOut => return Err(HeadError::NoTrigger),
            Wait::Failed => return Err(HeadError::Trigger),
        }
        self.exposure.light_on().map_err(|_| HeadError::Strobe)?;
        let summary = measure(detector, source, row, results, || wire.move_bytes(&mut line));
        self.after(summary, results, line)
    }

    /// Sends and receives what is possible at once, and carries out commands. For the time between frames, where there is
    /// much of it.
    ///
    /// # Errors
    /// Those of the line.
    pub fn serve<const N: usize>(
        &mut self,
        detector: &mut Detector<'_>,
        results: &mut Results<N>,
    ) -> Result<(), L::Error> {
        let mut line = Ok(());
        self.greet(detector, results.report.detail());
        self.wire.move_bytes(&mut line);
        // A command waits until there is room for its answer.
        while self.wire.has_command() && self.wire.room() >= RESERVE && line.is_ok() {
            self.obey(detector, results);
            self.wire.move_bytes(&mut line);
        }
        line
    }

    /// Sends all that waits. Blocks until the line has taken it.
    ///
    /// # Errors
    /// Those of the line.
    pub fn flush(&mut self) -> Result<(), L::Error> {
        self.wire.flush()
    }

    /// The line.
    pub fn line_mut(&mut self) -> &mut L {
        &mut self.wire.line
    }

    /// Gives line and exposure back. What waits to be sent is lost.
    pub fn release(self) -> (L, Exposure<S, T, D>) {
        (self.wire.line, self.exposure)
    }

    /// Light off, and the report to the line.
    fn after<E, const N: usize>(
        &mut self,
        summary: Result<Summary, HeadError<E, L::Error>>,
        results: &mut Results<N>,
        line: Result<(), L::Error>,
    ) -> Result<Summary, HeadError<E, L::Error>> {
        self.exposure.light_off().map_err(|_| HeadError::Strobe)?;
        let summary = summary?;
        self.send(&mut results.report, &summary).map_err(HeadError::Report)?;
        line.map_err(HeadError::Line)?;
        Ok(summary)
    }

    /// Puts the report behind what waits, or gives it up.
    fn send<const N: usize>(&mut self, report: &mut Report<N>, summary: &Summary) -> Result<(), EncodeError> {
        let format = self.format;
        let sent = self.wire.append(RESERVE, |free| match format {
            Format::Binary => report.finish(summary, free),
            Format::Text => report.finish_text(summary, free),
        });
        if let Err(error) = sent {
            log!(warn, "report given up: {}", error);
            report.give_up();
            // An empty buffer that cannot hold the report never will.
            if self.wire.waiting() == 0 {
                return Err(error);
            }
        }
        Ok(())
    }

    fn greet(&mut self, detector: &Detector<'_>, detail: Detail) {
        if self.hello_due {
            let hello = Hello::new(self.firmware, detector.max_width(), detail);
            self.hello_due = self.wire.append(0, |free| hello.encode(free)).is_err();
        }
    }

    fn obey<const N: usize>(&mut self, detector: &mut Detector<'_>, results: &mut Results<N>) {
        let Some(arrived) = self.wire.take_command() else { return };
        let Results { report, tracker } = results;
        let (mut settings, mut detail, mut period) =
            (*detector.settings(), report.detail(), tracker.period());
        let change = Changeable {
            settings: &mut settings,
            detail: &mut detail,
            format: &mut self.format,
            period: &mut period,
            hello: &mut self.hello_due,
        };
        let (tag, outcome) = remote::carry_out(arrived, change);
        log!(info, "command {}: {}", tag, outcome);
        detector.set_settings(settings);
        if detail != report.detail() {
            report.set_detail(detail);
        }
        tracker.set_period(period);
        self.greet(detector, detail);
        let settings = HeadSettings::new(&settings, detail, self.format, period);
        let answer = Answer { tag, outcome, settings };
        // There is room: a command waits for it.
        let _ = self.wire.append(0, |free| answer.encode(free));
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
    /// The report is longer than the buffer.
    Report(EncodeError),
    /// The line failed.
    Line(L),
    /// The light's pin failed.
    Strobe,
    /// The trigger's pin failed.
    Trigger,
    /// No trigger came in its time.
    NoTrigger,
}

impl<S: fmt::Debug, L: fmt::Debug> fmt::Display for HeadError<S, L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Source(error) => write!(f, "sensor: {error:?}"),
            Self::Frame(error) => write!(f, "{error}"),
            Self::Row(error) => write!(f, "{error}"),
            Self::Report(error) => write!(f, "report: {error}"),
            Self::Line(error) => write!(f, "line: {error:?}"),
            Self::Strobe => write!(f, "the light's pin failed"),
            Self::Trigger => write!(f, "the trigger's pin failed"),
            Self::NoTrigger => write!(f, "no trigger came in its time"),
        }
    }
}

impl<S: fmt::Debug, L: fmt::Debug> core::error::Error for HeadError<S, L> {}
