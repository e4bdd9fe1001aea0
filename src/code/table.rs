//! The words of a ring code, in the order of their ids.

/// Most segments.
pub(super) const SEGMENTS: u32 = 14;
/// Number of words of 14 segments.
pub(super) const COUNT_14: usize = 516;
/// Number of words of 12 segments.
pub(super) const COUNT_12: usize = 147;

pub(super) static WORDS_14: [u16; COUNT_14] = words(14);
pub(super) static WORDS_12: [u16; COUNT_12] = words(12);

/// `word` read from the segment `turn` places further on.
pub(super) const fn rotated(word: u16, turn: u32, segments: u32) -> u16 {
    let all = (1 << segments) - 1;
    ((word << turn) | (word >> (segments - turn))) & all
}

/// Whether `word` is in the code: the smallest of its rotations, an even number of segments set, and two opposite ones among
/// them; at least one is not set.
const fn is_word(word: u16, segments: u32) -> bool {
    let half = segments / 2;
    if !word.count_ones().is_multiple_of(2) || (word & (word >> half)) == 0 || word == (1 << segments) - 1 {
        return false;
    }
    let mut turn = 1;
    while turn < segments {
        if rotated(word, turn, segments) < word {
            return false;
        }
        turn += 1;
    }
    true
}

const fn words<const COUNT: usize>(segments: u32) -> [u16; COUNT] {
    let mut words = [0; COUNT];
    let (mut found, mut word) = (0, 1);
    while found < COUNT {
        if is_word(word, segments) {
            words[found] = word;
            found += 1;
        }
        // The smallest rotation of a word that is not 0 ends in a segment that is set.
        word += 2;
    }
    words
}
