//! The command `monitor`: a head's stream of reports in, JSON lines out.

mod ask;
pub mod command;
pub(crate) mod json;
mod source;

use concentric::report::{DecodeError, Decoder, Detail, Message, max_len};
use serde::Serialize;

pub use source::Source;

/// Longest message that is taken, bytes: a full report of a thousand targets.
pub const LEN: usize = max_len(1000, Detail::Full);

/// A decoder with room for any report.
pub fn decoder() -> Box<Decoder<LEN>> {
    Box::new(Decoder::new())
}

/// What a stream held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Bytes taken.
    pub bytes: u64,
    /// Hellos.
    pub hellos: u64,
    /// Frame reports.
    pub frames: u64,
    /// Frames missing between those, by their sequence numbers.
    pub lost: u64,
    /// Times the sequence number did not rise: the head was reset.
    pub restarts: u64,
    /// Stretches between separators that are no message.
    pub damaged: u64,
    /// 1 if the stream ends in mid-message.
    pub truncated: u64,
}

/// Something to tell of a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A message, as one line of JSON without its end.
    Line(String),
    /// The answer to the command with this tag, as such a line.
    Answer(u16, String),
    /// Bytes that are no message.
    Damaged {
        /// Why.
        error: DecodeError,
        /// How many, without separators.
        len: u64,
        /// How many there were before them.
        at: u64,
    },
}

/// Decodes and counts a stream.
pub struct Monitor {
    decoder: Box<Decoder<LEN>>,
    counts: Counts,
    last: Option<u32>,
}

impl Default for Monitor {
    fn default() -> Self {
        Self { decoder: decoder(), counts: Counts::default(), last: None }
    }
}

impl Monitor {
    /// Takes the next byte of the stream.
    pub fn push(&mut self, byte: u8) -> Option<Event> {
        let len = self.decoder.pending() as u64;
        let at = self.counts.bytes - len;
        self.counts.bytes += 1;
        Some(match self.decoder.push(byte)? {
            Ok(Message::Hello(hello)) => {
                self.counts.hellos += 1;
                Event::Line(json::hello(&hello))
            }
            Ok(Message::Frame(frame)) => {
                self.counts.frames += 1;
                let seq = frame.head.seq;
                let line = json::frame(&frame);
                self.follow(seq);
                Event::Line(line)
            }
            Ok(Message::Answer(answer)) => Event::Answer(answer.tag, json::answer(&answer)),
            Err(error) => {
                self.counts.damaged += 1;
                Event::Damaged { error, len, at }
            }
        })
    }

    /// Sequence numbers wrap around: less than half of their range ahead is a gap, anything else a restart.
    fn follow(&mut self, seq: u32) {
        if let Some(last) = self.last.replace(seq) {
            match seq.wrapping_sub(last) {
                0 | 0x8000_0000.. => self.counts.restarts += 1,
                step => self.counts.lost += u64::from(step - 1),
            }
        }
    }

    /// Bytes of the message that the stream is in the middle of.
    pub fn pending(&self) -> usize {
        self.decoder.pending()
    }

    /// The counts so far, if the stream goes on.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The counts, if the stream ends here.
    pub fn finish(&self) -> Counts {
        Counts { truncated: u64::from(self.pending() > 0), ..self.counts }
    }
}
