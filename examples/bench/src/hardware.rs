//! Everything that needs `unsafe`.

#![allow(unsafe_code)]

use core::arch::asm;
use core::panic::PanicInfo;
use core::{ptr, slice};

use crate::Memory;
use crate::measure::Region;

/// Bytes of memory that hold frames, from the board's memory map.
const FRAMES_LENGTH: usize = 16 << 20;

/// The memory in which the emulator has laid the frames before the firmware started.
pub fn frames() -> &'static [u8] {
    unsafe extern "C" {
        static _frames_start: u8;
    }
    // SAFETY: memory that exists and that nobody writes.
    unsafe { slice::from_raw_parts(&raw const _frames_start, FRAMES_LENGTH) }
}

/// The memory of the measurement; called once.
pub fn memory() -> &'static mut Memory {
    static mut MEMORY: Memory = Memory::new();
    let memory = &raw mut MEMORY;
    // SAFETY: `main` is the only caller and runs once.
    unsafe { &mut *memory }
}

#[repr(align(256))]
#[expect(dead_code, reason = "written by address")]
struct Marks([u32; 64]);

static mut MARKS: Marks = Marks([0; 64]);

/// Everything since the last mark was work of this region.
#[inline(always)]
pub fn mark(region: Region) {
    bench_mark(region as u32);
}

/// The plugin looks for this function and for the address that it stores to.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn bench_mark(region: u32) {
    // SAFETY: the table has a word for every six bits, and nothing else refers to it.
    unsafe { (&raw mut MARKS).cast::<u32>().add(region as usize & 63).write_volatile(region) }
}

/// Bytes below a function's stack that are watched.
const WATCHED: usize = 48 << 10;
const PAINT: u32 = 0xC010_55A1;

/// The stack pointer of the function that this is inlined into.
#[inline(always)]
fn stack_pointer() -> usize {
    let pointer: usize;
    // SAFETY: reads a register.
    unsafe {
        #[cfg(target_arch = "arm")]
        asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags));
        #[cfg(target_arch = "riscv32")]
        asm!("mv {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags));
    }
    pointer
}

/// Calls a function and tells how many bytes of stack it took.
#[inline(never)]
pub fn with_stack<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let top = stack_pointer() & !3;
    paint(top - WATCHED);
    let result = work();
    let mut lowest = top - WATCHED;
    // SAFETY: the words lie in the board's RAM, which is far larger than the stack.
    while lowest < top && unsafe { ptr::with_exposed_provenance::<u32>(lowest).read_volatile() } == PAINT {
        lowest += size_of::<u32>();
    }
    (result, top - lowest)
}

/// Paints the free stack from `start` up to this function's own part, which may yet grow when the pointer is read.
#[inline(never)]
fn paint(start: usize) {
    let end = (stack_pointer() & !3) - 128;
    for place in (start..end).step_by(size_of::<u32>()) {
        // SAFETY: below the stack pointer nothing lives.
        unsafe { ptr::with_exposed_provenance_mut::<u32>(place).write_volatile(PAINT) }
    }
}

/// Halts.
#[cfg(feature = "panics-halt")]
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {}
}

/// Calls a function that exists nowhere: as long as any path leads here, the program does not link.
#[cfg(not(feature = "panics-halt"))]
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_is_reachable() -> !;
    }
    // SAFETY: never runs, because a program with this call in it cannot be linked.
    unsafe { a_panic_is_reachable() }
}
