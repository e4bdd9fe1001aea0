//! What Arm can do and stable Rust does not offer.

#[cfg(concentric_dsp)]
pub(crate) mod dsp;

use core::arch::naked_asm;

use crate::scan::kernel::MOST;
use crate::scan::strips::{FLAGS, RESTLESS, WINDOW};

/// Square root, correctly rounded.
// The assembler is told of the unit, because it does not take it from the target.
// SAFETY: the targets of which this is a part pass `x` and return the root in the register s0, and have the instruction.
#[cfg(target_abi = "eabihf")]
#[unsafe(naked)]
pub(crate) extern "C" fn sqrt(x: f32) -> f32 {
    naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}

/// Copies lines of 32 bytes, as many as both have: several words by an instruction, which no loop is compiled to.
pub(crate) fn copy(to: &mut [[u32; 8]], from: &[[u32; 8]]) {
    let count = to.len().min(from.len());
    if count > 0 {
        // SAFETY: both have `count` lines, and as one can be written to they do not overlap.
        unsafe { copy_lines(to.as_mut_ptr(), from.as_ptr(), count) }
    }
}

/// Copies a line by way of the registers in `$by`.
macro_rules! copy_line {
    ($($by:literal),+) => {
        concat!($("ldmia r1!, {{", $by, "}}\nstmia r0!, {{", $by, "}}\n"),+)
    };
}

/// Copies `count` lines, at least one.
// SAFETY: the arguments come in r0 to r2; the other registers are the caller's and are given back; every Arm has the instructions.
#[cfg(not(target_abi = "eabihf"))]
#[unsafe(naked)]
unsafe extern "C" fn copy_lines(to: *mut [u32; 8], from: *const [u32; 8], count: usize) {
    naked_asm!(
        "push {{r4, r5, r6, lr}}",
        "lsrs r2, r2, #1",
        "bcc 1f",
        // An odd one.
        copy_line!("r3, r4, r5, r6", "r3, r4, r5, r6"),
        "cmp r2, #0",
        "beq 2f",
        "1:",
        copy_line!("r3, r4, r5, r6", "r3, r4, r5, r6"),
        copy_line!("r3, r4, r5, r6", "r3, r4, r5, r6"),
        "subs r2, r2, #1",
        "bne 1b",
        "2:",
        "pop {{r4, r5, r6, pc}}",
    )
}

/// The same with a line in the registers at a time.
// SAFETY: as above; those with a unit for floating-point numbers have the instructions.
#[cfg(target_abi = "eabihf")]
#[unsafe(naked)]
unsafe extern "C" fn copy_lines(to: *mut [u32; 8], from: *const [u32; 8], count: usize) {
    naked_asm!(
        "push {{r4, r5, r6, r7, r8, r9, r10, lr}}",
        "lsrs r2, r2, #1",
        "bcc 1f",
        // An odd one.
        copy_line!("r3, r4, r5, r6, r7, r8, r9, r10"),
        "1:",
        "lsrs r2, r2, #1",
        "bcc 2f",
        // An odd pair.
        copy_line!("r3, r4, r5, r6, r7, r8, r9, r10", "r3, r4, r5, r6, r7, r8, r9, r10"),
        "2:",
        "beq 4f",
        "3:",
        copy_line!("r3, r4, r5, r6, r7, r8, r9, r10", "r3, r4, r5, r6, r7, r8, r9, r10"),
        copy_line!("r3, r4, r5, r6, r7, r8, r9, r10", "r3, r4, r5, r6, r7, r8, r9, r10"),
        "subs r2, r2, #1",
        "bne 3b",
        "4:",
        "pop {{r4, r5, r6, r7, r8, r9, r10, pc}}",
    )
}

/// The number of strips, from the first on, that are not restless and of which the words `first`, `first + 2` and so on of
/// `lines` stay in their windows: what [`within`](crate::scan::kernel::within) finds, in the eight registers that the
/// smallest processors have.
pub(crate) fn calm(strips: &[[u32; 16]], lines: &[[u32; 8]], first: usize, width: u32) -> usize {
    let count = strips.len().min(lines.len());
    let Some(words) = lines.as_flattened().get(first % 2..).filter(|_| count > 0) else { return 0 };
    // SAFETY: there are `count` strips and lines, and of a line the last word that is read is the sixth after the first.
    unsafe { calm_strips(strips.as_ptr(), words.as_ptr(), count, width) }
}

/// Halves the levels in a register.
#[cfg(not(target_abi = "eabihf"))]
macro_rules! halve {
    ($levels:literal) => {
        concat!("lsrs ", $levels, ", #1\nands ", $levels, ", r3\n")
    };
}
#[cfg(target_abi = "eabihf")]
macro_rules! halve {
    ($levels:literal) => {
        concat!("and ", $levels, ", r3, ", $levels, ", lsr #1\n")
    };
}

/// Takes the word so many bytes after r1 into r5 and r6.
macro_rules! next_word {
    ($at:literal) => {
        concat!(
            "ldr r7, [r1, #",
            $at,
            "]\n",
            halve!("r7"),
            "adds r7, r7, r4\nands r5, r7\nadd r7, r8\norrs r6, r7"
        )
    };
}

/// The same for `count` strips, at least one, whose words begin at `words`.
// SAFETY: the arguments come in r0 to r3 and the result goes in r0; the other registers are the caller's and are given back;
// every Arm has the instructions.
#[unsafe(naked)]
unsafe extern "C" fn calm_strips(
    strips: *const [u32; 16],
    words: *const u32,
    count: usize,
    width: u32,
) -> usize {
    // r2: strips left, r3: a mask, r4: the window's lower end, r5: all, r6: any, r8: less its width, r12: all strips.
    naked_asm!(
        "push {{r4, r5, r6, r7, lr}}",
        "mov r4, r8",
        "push {{r4}}",
        "mov r12, r2",
        "rsbs r3, r3, #0",
        "mov r8, r3",
        "ldr r3, 3f",
        "1:",
        "ldr r4, [r0, {window}]",
        "ldr r5, [r1]",
        halve!("r5"),
        "adds r5, r5, r4",
        "mov r6, r5",
        "add r6, r8",
        next_word!(8),
        next_word!(16),
        next_word!(24),
        // The top bits of all, of none of any.
        "bics r5, r6",
        "mvns r5, r5",
        "bics r5, r3",
        "bne 2f",
        "ldr r7, [r0, {flags}]",
        "lsls r7, r7, {calm}",
        "bne 2f",
        "adds r0, #64",
        "adds r1, #32",
        "subs r2, r2, #1",
        "bne 1b",
        "2:",
        "mov r0, r12",
        "subs r0, r0, r2",
        "pop {{r4}}",
        "mov r8, r4",
        "pop {{r4, r5, r6, r7, pc}}",
        ".p2align 2",
        "3: .word {most}",
        window = const 4 * WINDOW,
        flags = const 4 * FLAGS,
        calm = const RESTLESS.leading_zeros(),
        most = const MOST,
    )
}
