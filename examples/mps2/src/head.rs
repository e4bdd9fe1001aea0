//! From a frame in the mailbox to bytes on the serial line.

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
        self.buffers.report.begin(seq);
        let Some(summary) = self.scan(settings, frame, mailbox) else {
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

    /// Pushes the rows of the frame and collects its targets; `None` when the detector cannot take its size.
    fn scan(&mut self, settings: Settings, frame: &Frame, mailbox: &Mailbox) -> Option<Summary> {
        let Buffers { row, report, .. } = &mut *self.buffers;
        let row = row.get_mut(..frame.width as usize)?;
        let mut detector = Detector::new(settings, self.storage);
        let mut scan = detector.begin(frame.width.try_into().ok()?, frame.height.try_into().ok()?).ok()?;
        for y in 0..frame.height as usize {
            mailbox.copy_row(y, row);
            for target in scan.push_row(row).ok()? {
                report.push(&target);
            }
        }
        let mut rest = scan.finish().ok()?;
        for target in rest.by_ref() {
            report.push(&target);
        }
        Some(rest.summary())
    }
}

fn send(line: &mut Uart, bytes: &[u8]) -> u32 {
    let Ok(()) = line.write_all(bytes);
    let Ok(()) = line.flush();
    bytes.len() as u32
}
