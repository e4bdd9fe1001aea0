//! What was measured.

use std::collections::{BTreeMap, BTreeSet};
use std::iter::Sum;
use std::ops::Add;

use serde::{Deserialize, Serialize};

/// Everything that was measured in a run of the command.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Results {
    /// Version of the emulator.
    pub emulator: String,
    /// A processor each.
    pub processors: Vec<Measured>,
}

/// What was measured on a processor.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Measured {
    /// Its short name.
    pub processor: String,
    /// The compiler, and how it came by `core`.
    pub compiler: String,
    /// Bytes of the whole image in flash.
    pub flash: u64,
    /// Bytes of it that the library takes, for speed as in the image; not in the quick form.
    pub library_flash: Option<u64>,
    /// The same with the library compiled for size.
    pub library_flash_small: Option<u64>,
    /// What it is smaller by without each of its features, compiled for size; not in the quick form.
    #[serde(default)]
    pub features: BTreeMap<String, u64>,
    /// The same of the library without its features.
    #[serde(default)]
    pub lean: Option<Box<Measured>>,
    /// Symbols that may not be there.
    pub forbidden: Symbols,
    /// The stack below the function that measures a frame.
    pub stack: Stack,
    /// Whether every report has the bytes of the desktop's.
    pub reports_are_equal: bool,
    /// Whether a second run gave the same counts and reports.
    pub runs_are_equal: bool,
    /// A frame each.
    pub frames: Vec<Frame>,
    /// Where the instructions went: functions and their own instructions, most first.
    pub functions: Vec<(String, u64)>,
}

/// Numbers of symbols.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Symbols {
    pub panic: usize,
    pub heap: usize,
    pub f64: usize,
}

/// Depth of the stack.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stack {
    /// Most bytes that a frame took.
    pub measured: u64,
    /// Most bytes that any frame can take; `None` where it was not determined.
    pub bound: Option<u64>,
    /// The calls that take that much, each with its own bytes.
    pub chain: Vec<String>,
    /// What the bound does not know.
    pub unknown: BTreeSet<String>,
    /// Functions that call themselves.
    pub recursion: BTreeSet<String>,
}

/// What a frame cost.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Frame {
    /// What it shows.
    pub scene: String,
    /// Size, px.
    pub width: u32,
    pub height: u32,
    /// Targets found.
    pub targets: u32,
    /// Runs, outlines and crossings that did not fit.
    pub dropped: u32,
    /// Bytes of the storage that it was measured in.
    pub storage: u64,
    /// Rows up to the finished candidates.
    pub scan: Counts,
    /// Candidates to targets.
    pub target: Counts,
    /// Targets into the report.
    pub report: Counts,
}

impl Frame {
    /// All of it.
    pub fn total(&self) -> Counts {
        self.scan + self.target + self.report
    }

    /// Number of pixels.
    pub fn pixels(&self) -> f64 {
        f64::from(self.width) * f64::from(self.height)
    }

    /// Scene and size.
    pub fn name(&self) -> String {
        format!("{} {}x{}", self.scene, self.width, self.height)
    }
}

/// Counts of a piece of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    pub instructions: u64,
    pub loads: u64,
    pub stores: u64,
    /// Taken branches.
    pub branches: u64,
    /// Cycles of the model.
    pub cycles: u64,
}

impl Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            loads: self.loads + other.loads,
            stores: self.stores + other.stores,
            branches: self.branches + other.branches,
            cycles: self.cycles + other.cycles,
        }
    }
}

impl Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        counts.fold(Self::default(), Self::add)
    }
}

impl Results {
    /// What was measured on the processor of this short name.
    pub fn of(&self, processor: &str) -> Option<&Measured> {
        self.processors.iter().find(|measured| measured.processor == processor)
    }
}

impl Measured {
    /// The frame of this scene and width.
    pub fn frame(&self, scene: &str, width: u32) -> Option<&Frame> {
        self.frames.iter().find(|frame| frame.scene == scene && frame.width == width)
    }
}
