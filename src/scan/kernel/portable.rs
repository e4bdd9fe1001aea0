//! The bytes of words, compared by plain word arithmetic.

use super::{Bytes, Line, MOST, ONES, TOP, WORDS, half, select, spread};

/// By instructions that every processor has.
pub(crate) struct Portable;

impl Bytes for Portable {
    const WHOLE: bool = false;

    fn choose(a: u32, b: u32, yes: u32, no: u32) -> u32 {
        select(spread((a | TOP) - b), yes, no)
    }

    fn sort(a: u32, b: u32) -> [u32; 2] {
        let larger = Self::choose(a, b, MOST, 0);
        [select(larger, b, a), select(larger, a, b)]
    }

    fn less(a: u32, b: u32) -> u32 {
        let rest = (a | TOP) - b;
        rest & spread(rest)
    }

    fn dark<const ROWS: usize>(lines: [Option<&Line>; ROWS], thresholds: u32) -> [u32; ROWS] {
        let from = thresholds.to_le_bytes().map(|threshold| TOP - u32::from(threshold) * ONES);
        lines.map(|line| line.map_or(0, |line| dark(line, &from)))
    }
}

/// One bit for each pixel of a strip's row that is dark, first pixel lowest. `from` is 0x80 less half the threshold in each
/// byte, for each cell.
#[inline(never)]
fn dark(line: &Line, from: &[u32; WORDS / 2]) -> u32 {
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
