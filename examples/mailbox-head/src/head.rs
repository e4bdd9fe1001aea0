//! From a frame in the mailbox to bytes on the serial line.

use core::convert::Infallible;

use concentric::head::{Exposure, FrameStart, Head, HeadError, Line, RowSource, buffer_len};
use concentric::report::{Detail, Report};
use concentric::{Detector, Settings, SettingsError, TargetSpec};
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

use crate::mailbox::Mailbox;
use crate::protocol::{Answer, Frame, HeadStorage, MAX_TARGETS, MAX_WIDTH, Outcome, VERSION};

/// Buffers of the head. All zero at first, so that they cost no flash.
pub struct Buffers {
    row: [u8; MAX_WIDTH],
    report: Report<MAX_TARGETS>,
    bytes: [u8; buffer_len(MAX_TARGETS, Detail::Full)],
}

impl Buffers {
    /// Empty buffers.
    pub const fn new() -> Self {
        Self {
            row: [0; MAX_WIDTH],
            report: Report::new(Detail::Terse),
            bytes: [0; buffer_len(MAX_TARGETS, Detail::Full)],
        }
    }
}

impl Default for Buffers {
    fn default() -> Self {
        Self::new()
    }
}

/// Measures frames and sends their reports.
pub(crate) struct MailboxHead<L> {
    head: Head<'static, Counted<L>>,
    detector: Detector<'static>,
    row: &'static mut [u8],
    report: &'static mut Report<MAX_TARGETS>,
}

impl<L: Line<Error = Infallible>> MailboxHead<L> {
    pub(crate) fn new(line: L, storage: &'static mut HeadStorage, buffers: &'static mut Buffers) -> Self {
        let Buffers { row, report, bytes } = buffers;
        Self {
            head: Head::new(Counted { line, sent: 0 }, Exposure::free_running(), VERSION, bytes),
            detector: Detector::new(Settings::new(TargetSpec::any()), storage),
            row,
            report,
        }
    }

    /// Carries out commands.
    pub(crate) fn serve(&mut self) {
        let Ok(()) = self.head.serve(&mut self.detector, self.report);
    }

    /// Takes over the settings of an order.
    pub(crate) fn set(&mut self, frame: &Frame) -> Result<(), SettingsError> {
        self.detector.set_settings(frame.settings()?);
        if frame.detail() != self.report.detail() {
            self.report.set_detail(frame.detail());
            self.head.introduce();
        }
        Ok(())
    }

    /// Measures the frame in the mailbox and sends its report. Waits until all of it is sent, so that the answer has its
    /// length: the camera then knows how much to read.
    pub(crate) fn measure(&mut self, seq: u32, (width, height): (u32, u32), mailbox: &Mailbox) -> Answer {
        #[cfg(feature = "reachable-panic")]
        assert!(seq > 0);
        let (Ok(w), Ok(h)) = (u16::try_from(width), u16::try_from(height)) else {
            return Answer::refused(Outcome::WrongSize);
        };
        if !mailbox.holds(width, height) {
            return Answer::refused(Outcome::WrongSize);
        }
        let start = FrameStart { seq, width: w, height: h };
        let mut rows = MailboxRows { mailbox, start, next: 0 };
        let measured = self.head.frame(&mut self.detector, &mut rows, self.row, self.report);
        let Ok(()) = self.head.flush();
        match measured {
            Ok(summary) => {
                let length = self.head.line_mut().take_sent();
                Answer { outcome: Outcome::Done, targets: summary.targets, length }
            }
            Err(HeadError::Report(_)) => Answer::refused(Outcome::ReportTooLong),
            Err(_) => Answer::refused(Outcome::WrongSize),
        }
    }
}

/// The frame in the mailbox as a sensor.
struct MailboxRows<'m> {
    mailbox: &'m Mailbox,
    start: FrameStart,
    next: usize,
}

impl RowSource for MailboxRows<'_> {
    type Error = Infallible;

    fn start(&mut self) -> Result<FrameStart, Infallible> {
        Ok(self.start)
    }

    fn read_row(&mut self, row: &mut [u8]) -> Result<(), Infallible> {
        self.mailbox.copy_row(self.next, row);
        self.next += 1;
        Ok(())
    }
}

/// A line that counts what is sent.
struct Counted<L> {
    line: L,
    sent: u32,
}

impl<L> Counted<L> {
    fn take_sent(&mut self) -> u32 {
        core::mem::take(&mut self.sent)
    }
}

impl<L: ErrorType> ErrorType for Counted<L> {
    type Error = L::Error;
}

impl<L: Write> Write for Counted<L> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, L::Error> {
        let sent = self.line.write(bytes)?;
        self.sent = self.sent.wrapping_add(sent as u32);
        Ok(sent)
    }

    fn flush(&mut self) -> Result<(), L::Error> {
        self.line.flush()
    }
}

impl<L: WriteReady> WriteReady for Counted<L> {
    fn write_ready(&mut self) -> Result<bool, L::Error> {
        self.line.write_ready()
    }
}

impl<L: Read> Read for Counted<L> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, L::Error> {
        self.line.read(bytes)
    }
}

impl<L: ReadReady> ReadReady for Counted<L> {
    fn read_ready(&mut self) -> Result<bool, L::Error> {
        self.line.read_ready()
    }
}
