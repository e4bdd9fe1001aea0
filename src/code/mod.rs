//! Ring codes: numbers that targets carry.
//!
//! A coded target is a target as any other, with a ring of segments around it: paper from the outer circle to [`INNER`] times
//! its radius, segments from there to [`OUTER`], paper again up to [`QUIET`]. Its circles are those of a plain target, and so
//! are its centre and covariance, with the eccentricity removed. A segment has the tone of the outer circle (ink) where its bit is 1 and that of
//! the ground where it is 0; the word is read clockwise as the target is seen, most significant bit first, from any segment.
//!
//! The words are those of the 14-segment ring code in the order of their value, as on the sheets of AICON: Schneider,
//! DE 19733466 A1 (1997), expired; order as found by M. Petroff (2018). A word is the smallest of its
//! rotations, an even number of its segments is set, two opposite ones among them, and not all are: 516 words of 14
//! segments, 147 of 12. One wrong segment is therefore seen, but only a set of few ids whose words are far apart allows to
//! repair it: [`Code::five`], [`Code::only`].
//!
//! [`read()`] reads the code of a target on the pixels, when the image is in memory.

mod read;
mod table;

pub use read::read;

use core::fmt;
use table::{COUNT_14, WORDS_12, WORDS_14, rotated};

/// Inner radius of the segments, in outer radii of the target.
pub const INNER: f32 = 1.4;
/// Outer radius of the segments.
pub const OUTER: f32 = 1.8;
/// Radius up to which there is nothing but ground around them.
pub const QUIET: f32 = 2.2;

/// Words of the set of ids.
const SET: usize = COUNT_14 / 32 + 1;
/// Most ids for which [`Code::only`] looks for what can be repaired. More have words that differ in two segments.
const FEW: usize = 32;

/// Which code targets carry, and which of its ids occur.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Code {
    segments: u8,
    repairs: u8,
    /// Bit `id % 32` of word `id / 32`.
    ids: [u32; SET],
}

/// The id of a word that was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Decoded {
    /// The id, from 1.
    pub id: u16,
    /// How many segments after the first one read the id's word begins.
    pub turn: u8,
    /// Segments that were repaired.
    pub wrong: u8,
}

/// The code of a target, as it was read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading {
    /// The id, from 1.
    pub id: u16,
    /// Direction in the image from the true centre to where the first segment of the id's word begins, from +x towards +y,
    /// radians in -pi..=pi; good to about 2 degrees on the target.
    pub angle: f32,
    /// Segments that were repaired or not clear: each is counted once.
    pub wrong: u8,
    /// How far the least clear of the other segments is from the middle between ink and ground, 0 to 1: 1 is wholly clear.
    pub margin: f32,
}

/// Ids that make no [`Code`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CodeError {
    /// An id that the code does not have.
    Id {
        /// The id given.
        given: u16,
        /// Largest one of the code.
        max: u16,
    },
    /// No id at all.
    NoIds,
}

impl fmt::Display for CodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id { given, max } => write!(f, "id {given} is outside 1..={max}"),
            Self::NoIds => write!(f, "no id given: a code needs one at least"),
        }
    }
}

impl core::error::Error for CodeError {}

const fn all_up_to(count: usize) -> [u32; SET] {
    let mut ids = [0; SET];
    let mut id = 1;
    while id <= count {
        ids[id / 32] |= 1 << (id % 32);
        id += 1;
    }
    ids
}

impl Code {
    /// The ids of [`five`](Self::five).
    pub const FIVE: [u16; 5] = [32, 123, 336, 366, 515];

    /// 14 segments, ids 1 to 516. Nothing is repaired.
    pub const fn cct14() -> Self {
        const IDS: [u32; SET] = all_up_to(COUNT_14);
        Self { segments: 14, repairs: 0, ids: IDS }
    }

    /// 12 segments, ids 1 to 147. Nothing is repaired.
    pub const fn cct12() -> Self {
        const IDS: [u32; SET] = all_up_to(table::COUNT_12);
        Self { segments: 12, repairs: 0, ids: IDS }
    }

    /// 14 segments, ids 32, 123, 336, 366 and 515: the largest set in which any two words differ in six segments or more
    /// whatever their rotation, so that two wrong segments are repaired. Where the word begins is less sure then: two segments
    /// of id 515 can be wrong so that it is 515 turned.
    pub const fn five() -> Self {
        const IDS: [u32; SET] = {
            let mut ids = [0; SET];
            let mut i = 0;
            while i < Code::FIVE.len() {
                let id = Code::FIVE[i] as usize;
                ids[id / 32] |= 1 << (id % 32);
                i += 1;
            }
            ids
        };
        Self { segments: 14, repairs: 2, ids: IDS }
    }

    /// The same segments with these ids only: no other is ever read, which is the strongest guard against wrong ones.
    /// Where at most 32 are given and their words are far enough apart, wrong segments are repaired: one where any two
    /// differ in four segments, two where they differ in six.
    ///
    /// # Errors
    /// [`CodeError::Id`] for an id that this code does not have; [`CodeError::NoIds`] if none is given.
    pub fn only(&self, ids: &[u16]) -> Result<Self, CodeError> {
        if ids.is_empty() {
            return Err(CodeError::NoIds);
        }
        let mut code = Self { ids: [0; SET], ..*self };
        for &id in ids {
            let max = self.words().len() as u16;
            match code.ids.get_mut(usize::from(id) / 32) {
                Some(set) if (1..=max).contains(&id) => *set |= 1 << (id % 32),
                _ => return Err(CodeError::Id { given: id, max }),
            }
        }
        code.repairs = code.repairable();
        Ok(code)
    }

    /// Number of segments: 12 or 14.
    pub const fn segments(&self) -> u32 {
        self.segments as u32
    }

    /// Wrong segments that are repaired.
    pub const fn repairs(&self) -> u32 {
        self.repairs as u32
    }

    /// Whether this id can be read.
    pub fn has(&self, id: u16) -> bool {
        self.ids.get(usize::from(id) / 32).is_some_and(|set| set >> (id % 32) & 1 == 1)
    }

    /// The ids that can be read, rising.
    pub fn ids(&self) -> impl Iterator<Item = u16> + '_ {
        (1..=self.words().len() as u16).filter(|&id| self.has(id))
    }

    /// The word of an id of this code, whether it can be read or not: a bit for each segment, the first one in bit
    /// `segments - 1`.
    pub fn word(&self, id: u16) -> Option<u16> {
        self.words().get(usize::from(id).checked_sub(1)?).copied()
    }

    fn words(&self) -> &'static [u16] {
        if self.segments == 12 { &WORDS_12 } else { &WORDS_14 }
    }

    /// The id of the segments `read`, which may begin anywhere. The work is a binary search, and where wrong segments are repaired up to 448
    /// comparisons of two words.
    pub fn decode(&self, read: u16) -> Option<Decoded> {
        let segments = self.segments();
        if read >> segments != 0 {
            return None;
        }
        let turns = (0..segments).map(|turn| (rotated(read, turn, segments), turn as u8));
        let (word, turn) = turns.min()?;
        if let Ok(index) = self.words().binary_search(&word) {
            let id = index as u16 + 1;
            if self.has(id) {
                return Some(Decoded { id, turn, wrong: 0 });
            }
        }
        if self.repairs == 0 { None } else { self.repaired(read) }
    }

    /// The same for a word that is none of an id that can be read.
    fn repaired(&self, read: u16) -> Option<Decoded> {
        self.ids().find_map(|id| {
            let (wrong, turn) = self.distance(read, self.word(id)?);
            (wrong <= self.repairs()).then_some(Decoded { id, turn, wrong: wrong as u8 })
        })
    }

    /// In how many segments `read` differs from `word` at the rotation in which they differ least, and that rotation.
    fn distance(&self, read: u16, word: u16) -> (u32, u8) {
        let segments = self.segments();
        let wrong = |turn| (rotated(read, turn, segments) ^ word).count_ones();
        (0..segments).map(|turn| (wrong(turn), turn as u8)).min().unwrap_or((segments, 0))
    }

    /// How many wrong segments the ids that can be read allow to repair.
    fn repairable(&self) -> u8 {
        if self.ids().count() > FEW {
            return 0;
        }
        let words = || self.ids().filter_map(|id| self.word(id));
        let least = words()
            .enumerate()
            .flat_map(|(k, word)| words().skip(k + 1).map(move |other| self.distance(word, other).0));
        // A single id is as far from nothing as the code lets any two be.
        let least = least.min().unwrap_or(6).min(6);
        (least.saturating_sub(1) / 2) as u8
    }
}

#[cfg(test)]
mod tests;
