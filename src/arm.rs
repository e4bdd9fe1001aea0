//! What the floating-point unit of Arm can do and stable Rust does not offer without `std`.

use core::arch::naked_asm;

/// Square root, correctly rounded.
// The assembler is told of the unit, because it does not take it from the target.
// SAFETY: the targets of which this is a part pass `x` and return the root in the register s0, and have the instruction.
#[unsafe(naked)]
pub(crate) extern "C" fn sqrt(x: f32) -> f32 {
    naked_asm!(".fpu fpv4-sp-d16", "vsqrt.f32 s0, s0", "bx lr")
}
