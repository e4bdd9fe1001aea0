//! The one variable that does not lie where the others do.

#![allow(unsafe_code)]

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

/// In the AXI SRAM (`memory.x`), which the start-up code does not touch.
#[unsafe(link_section = ".axisram")]
static mut FRAME: MaybeUninit<[u32; crate::FRAME_WORDS]> = MaybeUninit::uninit();

static TAKEN: AtomicBool = AtomicBool::new(false);

/// The memory of the frame; `None` from the second time on.
pub fn frame() -> Option<&'static mut [u32]> {
    if TAKEN.swap(true, Ordering::AcqRel) {
        return None;
    }
    let frame = &raw mut FRAME;
    // SAFETY: only one caller gets here, and nothing else names the variable.
    let frame = unsafe { &mut *frame };
    Some(frame.write([0; crate::FRAME_WORDS]))
}
