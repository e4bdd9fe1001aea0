//! The other direction: what a desktop asks of a head, and what the head answers.

use core::fmt;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::decoder::whole;
use super::unframe::Unframer;
use super::{DecodeError, Detail, EncodeError, Kind, frame};
use crate::{Compensation, Effort, Polarity, Settings};

/// How a head writes its reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Format {
    /// Messages, for programs.
    #[default]
    Binary,
    /// Lines, for terminals and controllers.
    Text,
}

/// Radii of the inner circles as ratios of the outer one, 1/65536, descending; empty: any circles.
///
/// More fit than are allowed, so that the refusal can say how many there were.
pub type Ratios = Vec<u16, 8>;

/// Unit of [`Ratios`].
pub const RATIO_ONE: f32 = 65536.0;

/// What is asked of a head, in the order of the numbers on the wire.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Request {
    /// Nothing but an answer, which has the settings in force.
    Settings,
    /// A hello.
    Hello,
    /// Other circles.
    Ratios(Ratios),
    /// Another polarity.
    Polarity(#[serde(with = "PolarityNumber")] Polarity),
    /// Another compensation. `Known` needs a head that knows its camera.
    Compensation(#[serde(with = "CompensationNumber")] Compensation),
    /// Another level of detail.
    Detail(Detail),
    /// Another format.
    Format(Format),
    /// One frame in so many is searched as a whole, the others only where targets are expected; 0 and 1: all as a whole.
    WholeEvery(u16),
    /// Pixels of the frame for each dark run, [`Settings::px_per_run`]; 0: no bound.
    PxPerRun(u16),
    /// Another effort for each target, [`Settings::effort`].
    Effort(#[serde(with = "EffortNumber")] Effort),
}

/// A request and a number to know its answer by.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Command {
    /// Comes back in the answer. 0 is for answers to what was not understood.
    pub tag: u16,
    /// What to do.
    pub request: Request,
}

impl Command {
    /// Encodes the command into the front of `buffer` and returns the bytes to send, a separator at either end: what the
    /// head has taken before does not spoil it. [`COMMAND_MAX_LEN`](super::COMMAND_MAX_LEN) bytes are always enough.
    ///
    /// # Errors
    /// [`EncodeError::BufferTooSmall`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        frame::encode(Kind::Command, self, buffer)
    }
}

/// What became of a command, and the settings after it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// Number of the command; 0: it could not be read.
    pub tag: u16,
    /// What became of it.
    pub outcome: Outcome,
    /// The settings that the next frame is measured with.
    pub settings: HeadSettings,
}

impl Answer {
    /// As [`Command::encode`]; [`ANSWER_MAX_LEN`](super::ANSWER_MAX_LEN) bytes are always enough.
    ///
    /// # Errors
    /// [`EncodeError::BufferTooSmall`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        frame::encode(Kind::Answer, self, buffer)
    }
}

/// What became of a command, in the order of the numbers on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Outcome {
    /// It was carried out.
    Done,
    /// A ratio is outside its range.
    Ratio {
        /// The one given, 1/65536.
        value: u16,
        /// Smallest one allowed, 1/65536.
        min: u16,
        /// Largest one allowed in its place, 1/65536.
        max: u16,
    },
    /// Too many ratios.
    RatioCount {
        /// How many were given.
        given: u8,
        /// Most that are allowed.
        max: u8,
    },
    /// The compensation `Known` needs a camera, and this head was built without one.
    NoCamera,
    /// Intact, and no command of this version of the format.
    Unknown,
    /// Bytes between two separators that are no message: damaged, or cut short.
    Damaged,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ratio = |units: u16| f32::from(units) / RATIO_ONE;
        match *self {
            Self::Done => f.write_str("done"),
            Self::Ratio { value, min, max } => {
                write!(f, "ratio {:.5} is outside {:.5}..={:.5}", ratio(value), ratio(min), ratio(max))
            }
            Self::RatioCount { given, max } => {
                write!(f, "{given} ratios given: 0..={max} inner circles are possible")
            }
            Self::NoCamera => f.write_str("compensation `known` needs a camera, and this head knows none"),
            Self::Unknown => f.write_str("no command that this head knows"),
            Self::Damaged => f.write_str("a command arrived damaged or cut short"),
        }
    }
}

/// The settings of a head that can be changed over its line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HeadSettings {
    /// What to look for.
    pub ratios: Ratios,
    /// Its polarity.
    #[serde(with = "PolarityNumber")]
    pub polarity: Polarity,
    /// How to compensate.
    #[serde(with = "CompensationNumber")]
    pub compensation: Compensation,
    /// How much is sent for a target.
    pub detail: Detail,
    /// How it is written.
    pub format: Format,
    /// Frames from one that is searched as a whole to the next; 0 and 1: all are.
    pub whole_every: u16,
    /// Pixels of the frame for each dark run that may be followed; 0: no bound.
    pub px_per_run: u16,
    /// How much is done for the accuracy of a target.
    #[serde(with = "EffortNumber")]
    pub effort: Effort,
}

impl HeadSettings {
    /// These settings of a detector and its reports.
    pub fn new(settings: &Settings, detail: Detail, format: Format, whole_every: u16) -> Self {
        let mut ratios = Ratios::new();
        for ratio in settings.spec.ratios() {
            // Cannot fail: a specification has fewer.
            let _ = ratios.push(crate::math::round(ratio * RATIO_ONE) as u16);
        }
        let polarity = settings.spec.polarity();
        let Settings { compensation, px_per_run, effort, .. } = *settings;
        Self { ratios, polarity, compensation, detail, format, whole_every, px_per_run, effort }
    }
}

/// Takes the commands to a head apart, byte by byte, as [`Decoder`](super::Decoder) does with its messages.
#[derive(Clone, Debug)]
pub struct CommandDecoder(Unframer<{ super::size::COMMAND_PLAIN }>);

impl Default for CommandDecoder {
    fn default() -> Self {
        Self::new()
    }
}

impl CommandDecoder {
    /// A decoder that expects the start of a command.
    pub const fn new() -> Self {
        Self(Unframer::new())
    }

    /// Takes the next byte of the stream; returns the outcome if it ends a stretch.
    ///
    /// # Errors
    /// Any [`DecodeError`]; decoding goes on with the next byte.
    pub fn push(&mut self, byte: u8) -> Option<Result<Command, DecodeError>> {
        Some(self.0.push(byte)?.and_then(|(kind, body)| {
            if kind == Kind::Command as u8 { whole(body) } else { Err(DecodeError::Kind(kind)) }
        }))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Polarity")]
enum PolarityNumber {
    Dark,
    Light,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Effort")]
enum EffortNumber {
    Full,
    Quick,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Compensation")]
enum CompensationNumber {
    None,
    Eq7,
    Exact,
    Auto,
    Known,
}
