//! From a frame in the mailbox to bytes on the serial line.

use core::convert::Infallible;

use concentric::head::{Exposure, FrameStart, Head, HeadError, Line, Results, RowSource, Runs, buffer_len};
use concentric::report::Detail;
use concentric::{Detector, RowError, Run, Settings, SettingsError, TargetSpec};
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

use crate::mailbox::Mailbox;
use crate::protocol::{
    Answer, Frame, HeadStorage, MAX_RUNS, MAX_TARGETS, MAX_WIDTH, Outcome, VERSION, words_in_row,
};

/// Buffers of the head. All zero at first, so that they cost no flash.
pub struct Buffers {
    row: [u8; MAX_WIDTH],
    runs: [Run; MAX_RUNS],
    results: Results<MAX_TARGETS>,
    bytes: [u8; buffer_len(MAX_TARGETS, Detail::Full)],
}

impl Buffers {
    /// Empty buffers.
    pub const fn new() -> Self {
        Self {
            row: [0; MAX_WIDTH],
            runs: [Run { start: 0, end: 0 }; MAX_RUNS],
            results: Results::new(Detail::Terse),
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
    runs: &'static mut [Run],
    results: &'static mut Results<MAX_TARGETS>,
}

impl<L: Line<Error = Infallible>> MailboxHead<L> {
    pub(crate) fn new(line: L, storage: &'static mut HeadStorage, buffers: &'static mut Buffers) -> Self {
        let Buffers { row, runs, results, bytes } = buffers;
        Self {
            head: Head::new(Counted { line, sent: 0 }, Exposure::free_running(), VERSION, bytes),
            detector: Detector::new(Settings::new(TargetSpec::any()), storage),
            row,
            runs,
            results,
        }
    }

    /// Carries out commands.
    pub(crate) fn serve(&mut self) {
        let Ok(()) = self.head.serve(&mut self.detector, self.results);
    }

    /// Takes over the settings of an order.
    pub(crate) fn set(&mut self, frame: &Frame) -> Result<(), SettingsError> {
        self.detector.set_settings(frame.settings()?);
        let report = &mut self.results.report;
        if frame.detail() != report.detail() {
            report.set_detail(frame.detail());
            self.head.introduce();
        }
        Ok(())
    }

    /// Measures the frame in the mailbox, whose rows are followed by their `runs` or not, and sends its report. Waits until
    /// all of it is sent, so that the answer has its length: the camera then knows how much to read.
    pub(crate) fn measure(
        &mut self,
        seq: u32,
        (width, height): (u32, u32),
        mailbox: &Mailbox,
        runs: bool,
    ) -> Answer {
        #[cfg(feature = "reachable-panic")]
        assert!(seq > 0);
        let (Ok(w), Ok(h)) = (u16::try_from(width), u16::try_from(height)) else {
            return Answer::refused(Outcome::WrongSize);
        };
        if !mailbox.holds(width, height) {
            return Answer::refused(Outcome::WrongSize);
        }
        let start = FrameStart { seq, width: w, height: h };
        let runs = runs.then_some(RowRuns { room: self.runs, count: 0, min_contrast: 0 });
        let mut rows = MailboxRows { mailbox, start, next: 0, runs };
        let measured = self.head.frame(&mut self.detector, &mut rows, self.row, self.results);
        let Ok(()) = self.head.flush();
        match measured {
            Ok(summary) => {
                let length = self.head.line_mut().take_sent();
                Answer { outcome: Outcome::Done, targets: summary.targets, length }
            }
            Err(HeadError::Report(_)) => Answer::refused(Outcome::ReportTooLong),
            Err(HeadError::Source(NoRuns) | HeadError::Row(RowError::Run { .. })) => {
                Answer::refused(Outcome::WrongRuns)
            }
            Err(_) => Answer::refused(Outcome::WrongSize),
        }
    }
}

/// More runs than a row can have, or than the mailbox has room for.
#[derive(Debug)]
struct NoRuns;

/// The runs of the row that was read last.
struct RowRuns<'r> {
    room: &'r mut [Run],
    count: usize,
    min_contrast: u8,
}

/// The frame in the mailbox as a sensor.
struct MailboxRows<'m> {
    mailbox: &'m Mailbox,
    start: FrameStart,
    /// Word of its pixels at which the next row begins.
    next: usize,
    runs: Option<RowRuns<'m>>,
}

impl RowSource for MailboxRows<'_> {
    type Error = NoRuns;

    fn start(&mut self) -> Result<FrameStart, NoRuns> {
        Ok(self.start)
    }

    fn read_row(&mut self, row: &mut [u8]) -> Result<(), NoRuns> {
        self.mailbox.copy_row(self.next, row);
        self.next += words_in_row(row.len());
        let Some(runs) = &mut self.runs else { return Ok(()) };
        let word = self.mailbox.pixel_word(self.next).ok_or(NoRuns)?;
        (runs.count, runs.min_contrast) = ((word & 0xFFFF) as usize, (word >> 16).min(255) as u8);
        let room = runs.room.get_mut(..runs.count).ok_or(NoRuns)?;
        for (i, run) in room.iter_mut().enumerate() {
            let word = self.mailbox.pixel_word(self.next + 1 + i).ok_or(NoRuns)?;
            *run = Run { start: word as u16, end: (word >> 16) as u16 };
        }
        self.next += 1 + runs.count;
        Ok(())
    }

    fn runs(&self) -> Option<Runs<'_>> {
        let RowRuns { room, count, min_contrast } = self.runs.as_ref()?;
        Some(Runs { runs: room.get(..*count)?, min_contrast: *min_contrast })
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
