//! What a head sends for each frame: one message, also when nothing was seen. And what it can be told over the same
//! line: a [`Command`], to which it gives an [`Answer`].
//!
//! [`Report`] collects a frame's targets and encodes them; [`Decoder`] takes the stream apart again, byte by byte,
//! and finds the next message after any damage. Neither needs a heap, a second buffer or a timer, and neither
//! can panic.
//!
//! ```
//! use concentric::report::{Decoder, Detail, EncodeError, Message, Report, max_len};
//! use concentric::{Summary, Target};
//!
//! const LEN: usize = max_len(60, Detail::Normal);
//! let mut report = Report::<60>::new(Detail::Normal);
//! let mut buffer = [0; LEN];
//!
//! report.begin(7);
//! report.push(&Target::default());
//! let summary = Summary { width: 640, height: 480, ..Summary::default() };
//! let bytes = report.finish(&summary, &mut buffer)?;
//!
//! let mut decoder = Decoder::<LEN>::new();
//! for &byte in bytes {
//!     if let Some(Ok(Message::Frame(frame))) = decoder.push(byte) {
//!         assert_eq!((frame.head.seq, frame.targets().count()), (7, 1));
//!     }
//! }
//! # Ok::<(), EncodeError>(())
//! ```
//!
#![doc = include_str!("SPECIFICATION.md")]

mod body;
mod command;
mod decoder;
mod fixed;
mod frame;
mod size;
mod text;
mod unframe;

pub use body::{
    CircleEntry, Detail, Details, FrameHead, FullEntry, Hello, Pixels, Shape, TargetEntry, Version,
};
pub use command::{
    Answer, Command, CommandDecoder, Format, HeadSettings, Outcome, RATIO_ONE, Ratios, Request,
};
pub use decoder::{DecodeError, Decoder, FrameReport, Message};
pub use frame::EncodeError;
pub use size::{ANSWER_MAX_LEN, COMMAND_MAX_LEN, HELLO_MAX_LEN, max_len};
pub use text::max_text_len;

use heapless::Vec;

use crate::track::Track;
use crate::{Summary, Target};

/// Version of the wire format, the first byte of every message.
pub const WIRE_VERSION: u8 = 5;

/// Byte that ends every message and occurs in none.
pub const SEPARATOR: u8 = 0;

/// Kind of a message, its second byte.
#[derive(Clone, Copy)]
#[repr(u8)]
enum Kind {
    Hello = 1,
    Frame = 2,
    Command = 3,
    Answer = 4,
}

/// The report of a frame in the making; holds up to `N` targets, up to 300 bytes each.
///
/// At level terse it is all zeros: a static that takes no flash. [`set_detail`](Self::set_detail) changes the level at run
/// time.
#[derive(Clone, Debug)]
pub struct Report<const N: usize> {
    detail: Detail,
    seq: u32,
    dropped: u32,
    given_up: u32,
    targets: Vec<TargetEntry, N>,
}

impl<const N: usize> Report<N> {
    /// An empty report of frame 0.
    pub const fn new(detail: Detail) -> Self {
        Self { detail, seq: 0, dropped: 0, given_up: 0, targets: Vec::new() }
    }

    /// Forgets the last frame and starts the report of frame `seq`. Counting every frame of the sensor, also
    /// those that were not looked at, lets the receiver see gaps.
    pub fn begin(&mut self, seq: u32) {
        self.seq = seq;
        self.dropped = 0;
        self.targets.clear();
    }

    /// Level of detail.
    pub fn detail(&self) -> Detail {
        self.detail
    }

    /// Changes the level of detail. The targets collected so far are forgotten.
    pub fn set_detail(&mut self, detail: Detail) {
        self.detail = detail;
        self.begin(self.seq);
    }

    /// Counts a report that is not sent, because the line has no room for it. All later reports tell how many there were.
    pub fn give_up(&mut self) {
        self.given_up = self.given_up.saturating_add(1);
    }

    /// Adds a target. When the report is full it is left out and counted.
    pub fn push(&mut self, target: &Target) {
        self.push_tracked(target, None);
    }

    /// The same with the target's track.
    pub fn push_tracked(&mut self, target: &Target, track: Option<&Track>) {
        if self.targets.push(TargetEntry::new(target, track, self.detail)).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// The targets in the report, in the order of [`push`](Self::push), in wire units.
    pub fn targets(&self) -> &[TargetEntry] {
        &self.targets
    }

    /// Encodes the report, separator included, into the front of `buffer` and returns the bytes to send.
    /// [`max_len(N, detail)`](max_len) bytes are always enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`]; the report is unchanged and can be encoded again.
    pub fn finish<'b>(&self, summary: &Summary, buffer: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        frame::encode(Kind::Frame, &(self.head(summary), self.targets()), buffer)
    }

    /// The same as lines of text, [specified](self#text) for terminals and controllers. Level full has no more than
    /// level normal. [`max_text_len(N, detail)`](max_text_len) bytes are always enough.
    ///
    /// # Errors
    ///
    /// As [`finish`](Self::finish).
    pub fn finish_text<'b>(&self, summary: &Summary, buffer: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        text::write(&self.head(summary), self.targets(), buffer)
    }

    fn head(&self, summary: &Summary) -> FrameHead {
        FrameHead {
            seq: self.seq,
            width: summary.width,
            height: summary.height,
            limited: summary.limited,
            rejected: summary.rejected,
            dropped: summary.dropped,
            unsearched: summary.unsearched,
            dropped_targets: self.dropped,
            dropped_reports: self.given_up,
            detail: self.detail,
        }
    }
}

impl Hello {
    /// Encodes the message into the front of `buffer` and returns the bytes to send. They begin with a separator,
    /// so that what a receiver has seen of the time before a reset does not spoil the message.
    /// [`HELLO_MAX_LEN`] bytes are always enough.
    ///
    /// # Errors
    ///
    /// [`EncodeError::BufferTooSmall`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        frame::encode(Kind::Hello, self, buffer)
    }
}
