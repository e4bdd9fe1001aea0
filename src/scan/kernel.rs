//! What is done to every pixel: four at a time, as the bytes of a word.
//!
//! Grey levels are halved first. The bit that this leaves free in each byte takes the carry of a sum or a difference, so that
//! plain word arithmetic compares four pixels. What the halving loses is nothing: thresholds are even.
//!
//! Arm's DSP extension compares whole bytes; what it does instead is in `src/arm/dsp.rs`, and must be the same to the bit.

/// Words of a strip's row.
pub(crate) const WORDS: usize = 8;
/// A row of a strip.
pub(crate) type Line = [u32; WORDS];

/// One in each byte.
pub(crate) const ONES: u32 = 0x0101_0101;
/// Top bit of each byte.
pub(crate) const TOP: u32 = 0x8080_8080;
/// The largest half level in each byte.
pub(crate) const MOST: u32 = !TOP;

/// How the bytes of words are compared, all below 0x80.
pub(crate) trait Bytes {
    /// Whether bytes up to 0xff can be sorted.
    const WHOLE: bool;

    /// In each byte `yes` where that of `a` is at least that of `b`, and `no` elsewhere.
    fn choose(a: u32, b: u32, yes: u32, no: u32) -> u32;

    /// The smaller and the larger of each byte.
    fn sort(a: u32, b: u32) -> [u32; 2];

    /// `a` less `b` in each byte, or 0 where `b` is larger.
    fn less(a: u32, b: u32) -> u32;

    /// One bit for each pixel of rows of a strip that is dark, first pixel lowest: of which half the level is below the byte of
    /// `thresholds` for its cell.
    fn dark<const ROWS: usize>(lines: [Option<&Line>; ROWS], thresholds: u32) -> [u32; ROWS];
}

// Where its better is there it is for tests.
#[cfg_attr(concentric_dsp, allow(dead_code))]
pub(crate) mod portable;

#[cfg(concentric_dsp)]
pub(crate) use crate::arm::dsp::Dsp as Best;
#[cfg(not(concentric_dsp))]
pub(crate) use portable::Portable as Best;

/// Half the levels of four pixels.
pub(crate) fn half(word: u32) -> u32 {
    word >> 1 & MOST
}

/// 0x7f in each byte whose top bit is set.
pub(crate) fn spread(tops: u32) -> u32 {
    (tops & TOP) - ((tops & TOP) >> 7)
}

/// In each byte `yes` where `mask` is 0x7f and `no` where it is 0.
pub(crate) fn select(mask: u32, yes: u32, no: u32) -> u32 {
    no ^ ((yes ^ no) & mask)
}

/// 0x7f in each byte of `a` that is at least that of `b`.
pub(crate) fn at_least(a: u32, b: u32) -> u32 {
    Best::choose(a, b, MOST, 0)
}

/// The smaller of each byte.
pub(crate) fn min(a: u32, b: u32) -> u32 {
    Best::choose(a, b, b, a)
}

/// The larger of each byte.
pub(crate) fn max(a: u32, b: u32) -> u32 {
    Best::choose(a, b, a, b)
}

/// Whether half the levels of every other word of `line`, from word `FIRST` on, are in a window: `low` is 0x80 less its lower
/// end in each byte, `width` one more than the distance to its upper end.
#[inline(always)]
pub(crate) fn within<const FIRST: usize>(line: &Line, low: u32, width: u32) -> bool {
    let high = low.wrapping_sub(width);
    let (mut all, mut any) = (TOP, 0);
    // No iterator that skips: it would become a loop.
    for word in [0, 2, 4, 6].map(|k| line[FIRST + k]) {
        let level = half(word);
        all &= level + low;
        any |= level.wrapping_add(high);
    }
    all & !any & TOP == TOP
}

/// Half the smallest and half the largest level of each of four cells, 8 px wide: bytes in the order of the columns.
#[inline(never)]
pub(crate) fn extremes(a: &Line, b: &Line) -> [u32; 2] {
    extremes_by::<Best>(a, b)
}

#[inline(always)]
pub(crate) fn extremes_by<B: Bytes>(a: &Line, b: &Line) -> [u32; 2] {
    let level = |word: u32| if B::WHOLE { u32::from_le(word) } else { half(u32::from_le(word)) };
    let pair = |k: usize| B::sort(level(a[k]), level(b[k + 1]));
    let [[l0, h0], [l1, h1], [l2, h2], [l3, h3]] = [pair(0), pair(2), pair(4), pair(6)];
    let [least, most] = [
        gather(|a, b| B::choose(a, b, b, a), [l0, l1, l2, l3]),
        gather(|a, b| B::choose(a, b, a, b), [h0, h1, h2, h3]),
    ];
    if B::WHOLE { [half(least), half(most)] } else { [least, most] }
}

/// The bytes of each of four words, `choose`n to one.
fn gather(choose: impl Fn(u32, u32) -> u32, [a, b, c, d]: [u32; 4]) -> u32 {
    const EVEN: u32 = 0x00ff_00ff;
    let halves = |a: u32, b: u32| choose((a & 0xffff) | b << 16, a >> 16 | (b & 0xffff_0000));
    let (ac, bd) = (halves(a, c), halves(b, d));
    choose((ac & EVEN) | (bd & EVEN) << 8, (ac >> 8 & EVEN) | (bd & !EVEN))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    /// Rows of every kind: flat, at either end, noisy, with one edge, with many.
    fn lines() -> Vec<[u8; 4 * WORDS]> {
        let mut seed = 1u32;
        let mut random = move |most: u32| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((seed >> 8) % (most + 1)) as u8
        };
        let mut lines = Vec::new();
        for level in 0..=255u8 {
            lines.push([level; 32]);
            lines.push([0; 32].map(|_: u8| level.saturating_add(random(8))));
            lines.push([0; 32].map(|_: u8| random(255)));
            let (edge, other) = (random(31), random(255));
            lines.push(core::array::from_fn(|x| if x < usize::from(edge) { level } else { other }));
            lines.push(core::array::from_fn(|x| if x % 2 == 0 { level } else { other }));
        }
        lines
    }

    fn words(bytes: &[u8; 4 * WORDS]) -> Line {
        core::array::from_fn(|k| u32::from_ne_bytes(*bytes[4 * k..].first_chunk().unwrap()))
    }

    #[test]
    fn a_window_has_both_its_ends_and_nothing_beyond() {
        let (mut inside, mut outside) = (0, 0);
        for line in lines() {
            for first in [0, 1] {
                let samples = (0..32).filter(|x| x / 4 % 2 == first).map(|x| u32::from(line[x] / 2));
                for (low, width) in [(0, 1), (60, 5), (u32::from(line[4] / 2), 9), (100, 28), (127, 127)] {
                    let expected = samples.clone().all(|level| (low..low + width).contains(&level));
                    let window = TOP - low * ONES;
                    let found = match first {
                        0 => within::<0>(&words(&line), window, width * ONES),
                        _ => within::<1>(&words(&line), window, width * ONES),
                    };
                    assert_eq!(found, expected, "{line:?} {low} {width}");
                    *(if found { &mut inside } else { &mut outside }) += 1;
                }
                assert!(!within::<0>(&words(&line), 0, ONES), "a window of which nothing is known");
            }
        }
        assert!(inside > 500 && outside > 500, "{inside} {outside}");
    }
}
