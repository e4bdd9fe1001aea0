//! What is done to every pixel: four at a time, as the bytes of a word.
//!
//! Grey levels are halved first. The bit that this leaves free in each byte takes the carry of a sum or a difference, so that
//! plain word arithmetic compares four pixels. What the halving loses is nothing: thresholds are even.

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

/// Half the levels of four pixels.
fn half(word: u32) -> u32 {
    word >> 1 & MOST
}

/// 0x7f in each byte whose top bit is set.
pub(crate) fn spread(tops: u32) -> u32 {
    (tops & TOP) - ((tops & TOP) >> 7)
}

/// 0x7f in each byte of `a` that is at least that of `b`, both below 0x80.
pub(crate) fn at_least(a: u32, b: u32) -> u32 {
    spread((a | TOP) - b)
}

/// In each byte `yes` where `mask` is 0x7f and `no` where it is 0.
pub(crate) fn select(mask: u32, yes: u32, no: u32) -> u32 {
    no ^ ((yes ^ no) & mask)
}

/// The smaller of each byte, both below 0x80.
pub(crate) fn min(a: u32, b: u32) -> u32 {
    select(at_least(a, b), b, a)
}

/// The larger of each byte, both below 0x80.
pub(crate) fn max(a: u32, b: u32) -> u32 {
    select(at_least(a, b), a, b)
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
    let pair = |k: usize| {
        let (p, q) = (half(u32::from_le(a[k])), half(u32::from_le(b[k + 1])));
        let larger = at_least(p, q);
        [select(larger, q, p), select(larger, p, q)]
    };
    let [[l0, h0], [l1, h1], [l2, h2], [l3, h3]] = [pair(0), pair(2), pair(4), pair(6)];
    [gather(min, [l0, l1, l2, l3]), gather(max, [h0, h1, h2, h3])]
}

/// The bytes of each of four words, `choose`n to one.
fn gather(choose: impl Fn(u32, u32) -> u32, [a, b, c, d]: [u32; 4]) -> u32 {
    const EVEN: u32 = 0x00ff_00ff;
    let halves = |a: u32, b: u32| choose((a & EVEN) | (b & EVEN) << 8, (a >> 8 & EVEN) | (b & !EVEN));
    let (ab, cd) = (halves(a, b), halves(c, d));
    choose((ab & 0xffff) | cd << 16, ab >> 16 | (cd & 0xffff_0000))
}

/// One bit for each pixel of a strip's row that is dark, first pixel lowest. `from` is 0x80 less half the threshold in each
/// byte, for each cell.
#[inline(never)]
pub(crate) fn dark(line: &Line, from: &[u32; WORDS / 2]) -> u32 {
    let mut light = 0;
    for (words, from) in line.as_chunks::<2>().0.iter().zip(from) {
        for word in words {
            light = light >> 1 | ((half(u32::from_le(*word)) + from) & TOP);
        }
    }
    match light {
        0 => !0,
        u32::MAX => 0,
        _ => !by_pixel(light),
    }
}

/// Moves bit 8 b + k, where the test of byte b of word k leaves it, to 4 k + b.
fn by_pixel(bits: u32) -> u32 {
    let swap = |bits: u32, by: u32, mask: u32| {
        let changed = (bits >> by ^ bits) & mask;
        bits ^ changed ^ changed << by
    };
    let bits = swap(bits, 12, 0x0000_f0f0);
    let bits = swap(bits, 6, 0x00cc_00cc);
    let bits = swap(bits, 3, 0x0a0a_0a0a);
    swap(bits, 1, 0x2222_2222)
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
    fn dark_is_a_comparison_of_every_pixel() {
        for (i, line) in lines().iter().enumerate() {
            let thresholds: [u32; 4] = core::array::from_fn(|c| (i * 31 + c * 77) as u32 % 128);
            let from = thresholds.map(|threshold| TOP - threshold * ONES);
            let expected = (0..32)
                .fold(0u32, |bits, x| bits | u32::from(u32::from(line[x]) < 2 * thresholds[x / 8]) << x);
            assert_eq!(dark(&words(line), &from), expected, "{line:?} {thresholds:?}");
        }
    }

    #[test]
    fn extremes_are_those_of_the_samples() {
        let lines = lines();
        for (a, b) in lines.iter().zip(lines.iter().rev()) {
            let cell = |c: usize| a[8 * c..][..4].iter().chain(&b[8 * c + 4..][..4]).map(|level| level / 2);
            let [low, high] = extremes(&words(a), &words(b)).map(u32::to_le_bytes);
            for c in 0..4 {
                assert_eq!(Some(low[c]), cell(c).min(), "{a:?} {b:?}");
                assert_eq!(Some(high[c]), cell(c).max(), "{a:?} {b:?}");
            }
        }
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
