//! From bytes back to the messages of a head.

use core::fmt;

use serde::Deserialize;

use super::body::{Detail, FrameHead, Hello, TargetEntry};
use super::command::Answer;
use super::unframe::Unframer;
use super::{Kind, WIRE_VERSION};

/// A message, taken apart.
#[derive(Clone, Debug)]
pub enum Message<'a> {
    /// Who is speaking.
    Hello(Hello),
    /// The report of a frame.
    Frame(FrameReport<'a>),
    /// What became of a command.
    Answer(Answer),
}

/// The report of a frame.
#[derive(Clone, Debug)]
pub struct FrameReport<'a> {
    /// What it says of the frame.
    pub head: FrameHead,
    targets: Targets<'a>,
}

impl<'a> FrameReport<'a> {
    /// The targets, in the order in which they were reported.
    pub fn targets(&self) -> impl Iterator<Item = TargetEntry> + Clone + 'a {
        self.targets.clone()
    }
}

/// Why the bytes between two separators are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DecodeError {
    /// Longer than the decoder can hold.
    TooLong,
    /// Not COBS: a block is longer than what there is.
    Cobs,
    /// Too short for version, kind and checksum.
    TooShort,
    /// The checksum does not match.
    Checksum,
    /// Intact, and in another version of the format.
    Version(u8),
    /// Intact, and of a kind that this version does not have.
    Kind(u8),
    /// Intact, and the body is not what its kind says.
    Body,
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong => f.write_str("message longer than the decoder can hold"),
            Self::Cobs => f.write_str("COBS block cut short"),
            Self::TooShort => f.write_str("too short for a message"),
            Self::Checksum => f.write_str("checksum does not match"),
            Self::Version(version) => {
                write!(f, "message of wire version {version}; this decoder reads version {WIRE_VERSION}")
            }
            Self::Kind(kind) => write!(f, "message of unknown kind {kind}"),
            Self::Body => f.write_str("message body does not match its kind"),
        }
    }
}

impl core::error::Error for DecodeError {}

/// Takes a head's stream of messages apart, byte by byte. Holds messages of up to `N` bytes before COBS;
/// [`max_len`](super::max_len) of the sender's report is always enough.
///
/// Each stretch of bytes between two separators has exactly one outcome, given at the separator that ends it: a
/// message, or why it is none. Empty stretches have none. A decoder that starts in mid-stream therefore gives one
/// error first.
#[derive(Clone, Debug)]
pub struct Decoder<const N: usize>(Unframer<N>);

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// A decoder that expects the start of a message.
    pub const fn new() -> Self {
        Self(Unframer::new())
    }

    /// Takes the next byte of the stream; returns the outcome if it ends a stretch.
    ///
    /// # Errors
    ///
    /// Any [`DecodeError`]; decoding goes on with the next byte.
    pub fn push(&mut self, byte: u8) -> Option<Result<Message<'_>, DecodeError>> {
        Some(self.0.push(byte)?.and_then(|(kind, body)| parse(kind, body)))
    }

    /// Bytes taken since the last separator. At the end of a stream: 0, or the length of the piece of a message that
    /// it was cut in.
    pub fn pending(&self) -> usize {
        self.0.pending()
    }
}

fn parse(kind: u8, body: &[u8]) -> Result<Message<'_>, DecodeError> {
    if kind == Kind::Hello as u8 {
        whole(body).map(Message::Hello)
    } else if kind == Kind::Frame as u8 {
        let (head, targets, rest) = parse_frame(body).map_err(|_| DecodeError::Body)?;
        let message = Message::Frame(FrameReport { head, targets });
        if rest.is_empty() { Ok(message) } else { Err(DecodeError::Body) }
    } else if kind == Kind::Answer as u8 {
        whole(body).map(Message::Answer)
    } else {
        Err(DecodeError::Kind(kind))
    }
}

/// A body that is one value and nothing else.
pub(super) fn whole<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, DecodeError> {
    match postcard::take_from_bytes(body) {
        Ok((value, [])) => Ok(value),
        _ => Err(DecodeError::Body),
    }
}

/// Head, targets, and what is left behind them.
fn parse_frame(body: &[u8]) -> postcard::Result<(FrameHead, Targets<'_>, &[u8])> {
    let ((head, left), bytes): ((FrameHead, u32), _) = postcard::take_from_bytes(body)?;
    let targets = Targets { detail: head.detail, left, bytes };
    let mut rest = bytes;
    for _ in 0..left {
        (_, rest) = TargetEntry::take(head.detail, rest)?;
    }
    Ok((head, targets, rest))
}

/// The targets of a report that was read through once without error.
#[derive(Clone, Debug)]
struct Targets<'a> {
    detail: Detail,
    left: u32,
    bytes: &'a [u8],
}

impl Iterator for Targets<'_> {
    type Item = TargetEntry;

    fn next(&mut self) -> Option<TargetEntry> {
        self.left = self.left.checked_sub(1)?;
        let (entry, rest) = TargetEntry::take(self.detail, self.bytes).ok()?;
        self.bytes = rest;
        Some(entry)
    }
}
