//! From a frame in the mailbox to bytes on the serial line.

use core::convert::Infallible;

use concentric::head::{self, FrameStart, RowSource};
use concentric::report::{Detail, HELLO_MAX_LEN, Hello, Report, max_len};
use concentric::{Detector, Settings, Summary};
use embedded_io::Write as _;

use crate::mailbox::Mailbox;
use crate::protocol::{Answer, Frame, HeadStorage, MAX_TARGETS, MAX_WIDTH, Outcome, VERSION};
use crate::uart::Uart;

/// Buffers of the head. All zero at first, so that they cost no flash.
pub struct Buffers {
    row: [u8; MAX_WIDTH],
    report: Report<MAX_TARGETS>,
    bytes: [u8; max_len(MAX_TARGETS, Detail::Full)],
}

impl Buffers {
    /// Empty buffers.
    pub const fn new() -> Self {
        Self {
            row: [0; MAX_WIDTH],
            report: Report::new(Detail::Terse),
            bytes: [0; max_len(MAX_TARGETS, Detail::Full)],
        }
    }
}

/// Measures frames and sends their reports.
pub struct Head {
    line: Uart,
    storage: &'static mut HeadStorage,
    buffers: &'static mut Buffers,
    /// Level of detail of the last hello.
    told: Option<Detail>,
}

impl Head {
    /// A head that sends its reports over `line`.
    pub fn new(line: Uart, storage: &'static mut HeadStorage, buffers: &'static mut Buffers) -> Self {
        Self { line, storage, buffers, told: None }
    }

    /// Measures the frame in the mailbox and sends its report, after a hello when its level of detail is new.
    pub fn measure(&mut self, seq: u32, frame: &Frame, mailbox: &Mailbox) -> Answer {
        #[cfg(feature = "reachable-panic")]
        assert!(seq > 0);
        let Ok(settings) = frame.settings() else {
            return Answer::refused(Outcome::WrongSettings);
        };
        if !mailbox.holds(frame) {
            return Answer::refused(Outcome::WrongSize);
        }
        self.buffers.report = Report::new(frame.detail());
        let Some(summary) = self.scan(settings, seq, frame, mailbox) else {
            return Answer::refused(Outcome::WrongSize);
        };
        let Ok(report) = self.buffers.report.finish(&summary, &mut self.buffers.bytes) else {
            return Answer::refused(Outcome::ReportTooLong);
        };
        let mut length = 0;
        if self.told != Some(frame.detail()) {
            self.told = Some(frame.detail());
            let mut bytes = [0; HELLO_MAX_LEN];
            let hello = Hello::new(VERSION, MAX_WIDTH as u16, frame.detail());
            if let Ok(hello) = hello.encode(&mut bytes) {
                length += send(&mut self.line, hello);
            }
        }
        length += send(&mut self.line, report);
        Answer { outcome: Outcome::Done, targets: summary.targets, length }
    }

    /// Measures the frame and collects its targets; `None` when the detector cannot take its size.
    fn scan(&mut self, settings: Settings, seq: u32, frame: &Frame, mailbox: &Mailbox) -> Option<Summary> {
        let Buffers { row, report, .. } = &mut *self.buffers;
        let start =
            FrameStart { seq, width: frame.width.try_into().ok()?, height: frame.height.try_into().ok()? };
        let mut detector = Detector::new(settings, self.storage);
        let mut rows = MailboxRows { mailbox, start, next: 0 };
        head::measure::<_, Infallible, _>(&mut detector, &mut rows, row, report).ok()
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

fn send(line: &mut Uart, bytes: &[u8]) -> u32 {
    let Ok(()) = line.write_all(bytes);
    let Ok(()) = line.flush();
    bytes.len() as u32
}
