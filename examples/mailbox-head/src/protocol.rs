//! The mailbox: a piece of memory that the camera (or a program that plays it) and the head share.
//!
//! 32-bit little-endian words. Both ends compile this file.
//!
//! | word | written by | meaning |
//! | --- | --- | --- |
//! | 0 | head | [`MAGIC`] once it is ready for the first order |
//! | 1 | camera | number of the order, 1 for the first; written last, when everything else of the order is there |
//! | 2.. | camera | the [`Order`] |
//! | 16 | head | number of the last order that is done; written last |
//! | 17.. | head | the [`Answer`] |
//! | 32.. | camera | pixels, row by row from the top; each row starts at a word |
//!
//! Where logic beside the sensor finds the dark runs, each row is followed by a word with their number in its lower and the least
//! contrast in its upper half, and a word for each run: the column of its first pixel in the lower half, the column after its last
//! in the upper one.
//!
//! A frame has the number of its order as sequence number. The pixels belong to the head from the moment the
//! number of the order is written until the same number stands in word 16.

#![allow(dead_code, reason = "each end needs a part of it")]

use concentric::report::{Detail, Version};
use concentric::{Compensation, Settings, SettingsError, Storage, TargetSpec};

/// "CON1": the mailbox of this page, first version.
pub const MAGIC: u32 = u32::from_le_bytes(*b"CON1");
/// Word with [`MAGIC`].
pub const READY: usize = 0;
/// Word with the number of the order.
pub const ORDERED: usize = 1;
/// First word of the [`Order`].
pub const ORDER: usize = 2;
/// Word with the number of the order that is done.
pub const DONE: usize = 16;
/// First word of the [`Answer`].
pub const ANSWER: usize = 17;
/// First word of the pixels.
pub const PIXELS: usize = 32;

/// Words of an [`Order`].
pub const ORDER_WORDS: usize = 7;
/// Words of an [`Answer`].
pub const ANSWER_WORDS: usize = 3;

/// Version of the firmware, for the hello.
pub const VERSION: Version = Version { major: 0, minor: 1, patch: 0 };
/// Widest frame, px.
pub const MAX_WIDTH: usize = 2048;
/// Most runs of a row.
pub const MAX_RUNS: usize = MAX_WIDTH.div_ceil(2);
/// Most targets in a report.
pub const MAX_TARGETS: usize = 64;
/// The memory of the head's detector. What does not fit is counted, and the counts are in the report: a desktop that
/// wants the head's bytes has to take the same.
pub type HeadStorage = Storage<MAX_WIDTH, 512, 8000>;

/// What the camera asks of the head.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Measure the frame in the mailbox with its settings and send its report.
    Measure(Frame),
    /// The same with the runs of each row behind it.
    MeasureWithRuns(Frame),
    /// [`Measure`](Self::Measure) with the settings that are in force: those of the last order or of a command since.
    MeasureAsSet {
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
    },
    /// Stop and give the host this exit status.
    Exit(u32),
}

/// A frame in the mailbox, and how it is to be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
    /// Inner radius of the wanted targets as a ratio of the outer one, in 1/65536; 0 for any circles.
    pub ratio: u32,
    /// 0 for targets that are dark on light, 1 for light on dark.
    pub light: u32,
    /// Correction of the centre: 0 none, 1 eq. (7), 2 exact, 3 automatic.
    pub compensation: u32,
    /// Level of detail of the report: 0 terse, 1 normal, 2 full.
    pub detail: u32,
}

impl Frame {
    /// Unit of the ratio.
    pub const RATIO_ONE: u32 = 1 << 16;

    /// The library's settings.
    ///
    /// # Errors
    /// The ratio is out of range. Other words are taken for the nearest in range.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let spec = match self.ratio {
            0 => TargetSpec::any(),
            ratio => TargetSpec::ring(ratio as f32 / Self::RATIO_ONE as f32)?,
        };
        let spec = if self.light == 0 { spec } else { spec.light() };
        Ok(Settings::new(spec).compensation(match self.compensation {
            0 => Compensation::None,
            1 => Compensation::Eq7,
            2 => Compensation::Exact,
            _ => Compensation::Auto,
        }))
    }

    /// The report's level of detail.
    pub fn detail(&self) -> Detail {
        match self.detail {
            0 => Detail::Terse,
            1 => Detail::Normal,
            _ => Detail::Full,
        }
    }
}

impl Order {
    const MEASURE: u32 = 1;
    const EXIT: u32 = 2;
    const MEASURE_AS_SET: u32 = 3;
    const MEASURE_WITH_RUNS: u32 = 4;

    /// The words of the order.
    pub fn to_words(self) -> [u32; ORDER_WORDS] {
        let words = |kind, f: Frame| [kind, f.width, f.height, f.ratio, f.light, f.compensation, f.detail];
        match self {
            Self::Measure(frame) => words(Self::MEASURE, frame),
            Self::MeasureWithRuns(frame) => words(Self::MEASURE_WITH_RUNS, frame),
            Self::MeasureAsSet { width, height } => [Self::MEASURE_AS_SET, width, height, 0, 0, 0, 0],
            Self::Exit(status) => [Self::EXIT, status, 0, 0, 0, 0, 0],
        }
    }

    /// The order in these words; `None` when they are none.
    pub fn from_words(words: [u32; ORDER_WORDS]) -> Option<Self> {
        let [kind, width, height, ratio, light, compensation, detail] = words;
        let frame = Frame { width, height, ratio, light, compensation, detail };
        match kind {
            Self::MEASURE => Some(Self::Measure(frame)),
            Self::MEASURE_WITH_RUNS => Some(Self::MeasureWithRuns(frame)),
            Self::MEASURE_AS_SET => Some(Self::MeasureAsSet { width, height }),
            Self::EXIT => Some(Self::Exit(width)),
            _ => None,
        }
    }
}

/// What became of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Outcome {
    /// Done.
    Done = 0,
    /// Not an order of this protocol.
    UnknownOrder = 1,
    /// The settings are outside their ranges: nothing was measured.
    WrongSettings = 2,
    /// The frame is empty, or larger than the head's memory allows: nothing was measured.
    WrongSize = 3,
    /// The report did not fit its buffer: it was not sent.
    ReportTooLong = 4,
    /// The runs of a row are none: the frame was given up.
    WrongRuns = 5,
}

impl Outcome {
    const ALL: [Self; 6] = [
        Self::Done,
        Self::UnknownOrder,
        Self::WrongSettings,
        Self::WrongSize,
        Self::ReportTooLong,
        Self::WrongRuns,
    ];

    /// What is wrong, and what is allowed.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Done => "nothing is wrong",
            Self::UnknownOrder => "the order is none that this firmware knows",
            Self::WrongSettings => "the ratio is outside 0.1 to 0.95",
            Self::WrongSize => {
                "the frame is smaller than 8x8 px, wider than 2048 px, or larger than the mailbox of 16 MB"
            }
            Self::ReportTooLong => "the report is longer than its buffer",
            Self::WrongRuns => "the runs of a row do not lie apart and from left to right within it",
        }
    }
}

/// What the head answers to an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// What became of the order.
    pub outcome: Outcome,
    /// Targets found.
    pub targets: u32,
    /// Bytes that went over the serial line since the last frame.
    pub length: u32,
}

impl Answer {
    /// An order that was not carried out.
    pub fn refused(outcome: Outcome) -> Self {
        Self { outcome, targets: 0, length: 0 }
    }

    /// The words of the answer.
    pub fn to_words(self) -> [u32; ANSWER_WORDS] {
        [self.outcome as u32, self.targets, self.length]
    }

    /// The answer in these words; `None` when they are none.
    pub fn from_words(words: [u32; ANSWER_WORDS]) -> Option<Self> {
        let [outcome, targets, length] = words;
        let outcome = Outcome::ALL.into_iter().find(|&known| known as u32 == outcome)?;
        Some(Self { outcome, targets, length })
    }
}

/// Words of a row of `width` pixels.
pub fn words_in_row(width: usize) -> usize {
    width.div_ceil(4)
}
