//! The bytes of words, compared by Arm's DSP extension.

use core::arch::asm;

use crate::scan::kernel::{Bytes, Line, ONES};

/// By instructions for four bytes each.
pub(crate) struct Dsp;

impl Bytes for Dsp {
    const WHOLE: bool = true;

    #[inline(always)]
    fn choose(a: u32, b: u32, yes: u32, no: u32) -> u32 {
        let chosen: u32;
        // SAFETY: `build.rs` has seen that the processor has the instructions; they change registers and flags only.
        unsafe {
            asm!(
                "usub8 {chosen}, {a}, {b}",
                "sel {chosen}, {yes}, {no}",
                a = in(reg) a,
                b = in(reg) b,
                yes = in(reg) yes,
                no = in(reg) no,
                chosen = out(reg) chosen,
                options(pure, nomem, nostack),
            );
        }
        chosen
    }

    #[inline(always)]
    fn sort(a: u32, b: u32) -> [u32; 2] {
        let (smaller, larger): (u32, u32);
        // SAFETY: as above.
        unsafe {
            asm!(
                "usub8 {smaller}, {a}, {b}",
                "sel {smaller}, {b}, {a}",
                "sel {larger}, {a}, {b}",
                a = in(reg) a,
                b = in(reg) b,
                smaller = out(reg) smaller,
                larger = lateout(reg) larger,
                options(pure, nomem, nostack),
            );
        }
        [smaller, larger]
    }

    #[inline(always)]
    fn less(a: u32, b: u32) -> u32 {
        let rest: u32;
        // SAFETY: as above.
        unsafe {
            asm!(
                "uqsub8 {rest}, {a}, {b}",
                a = in(reg) a,
                b = in(reg) b,
                rest = lateout(reg) rest,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        rest
    }

    #[inline(never)]
    fn dark<const ROWS: usize>(lines: [Option<&Line>; ROWS], thresholds: u32) -> [u32; ROWS] {
        let from = thresholds.to_le_bytes().map(|threshold| u32::from(threshold) * (2 * ONES));
        lines.map(|line| line.map_or(0, |line| dark(line, from)))
    }
}

/// One bit for each pixel of a strip's row that is below the byte of `from` for its cell.
#[inline(always)]
fn dark(line: &Line, [a, b, c, d]: [u32; 4]) -> u32 {
    let cell = |at: usize, from: u32| {
        // Each pixel has its own bit, so that their sum has them all.
        sum(Dsp::choose(line[at], from, 0, 0x0804_0201) | Dsp::choose(line[at + 1], from, 0, 0x8040_2010))
    };
    cell(0, a) | cell(2, b) << 8 | cell(4, c) << 16 | cell(6, d) << 24
}

/// The sum of four bytes.
#[inline(always)]
fn sum(bytes: u32) -> u32 {
    let sum: u32;
    // SAFETY: as above.
    unsafe {
        asm!(
            "usad8 {sum}, {bytes}, {zero}",
            bytes = in(reg) bytes,
            zero = in(reg) 0,
            sum = lateout(reg) sum,
            options(pure, nomem, nostack, preserves_flags),
        );
    }
    sum
}
