//! Everything that needs `unsafe`: where the registers are, and the memory that belongs to the head alone.

#![allow(unsafe_code)]

use concentric_mailbox_head::protocol::HeadStorage;
use concentric_mailbox_head::{Buffers, Words};
use riscv::register::mie;

/// Ticks of the timer in a second.
pub const TIMER_HZ: u64 = 10_000_000;
/// Words of the timer (CLINT): when it wakes the first core, and the time.
pub const COMPARE_LOW: usize = 0x4000 / 4;
pub const COMPARE_HIGH: usize = COMPARE_LOW + 1;
pub const TIME_LOW: usize = 0xBFF8 / 4;
pub const TIME_HIGH: usize = TIME_LOW + 1;

/// The buffers of the head.
pub struct Memory {
    pub storage: &'static mut HeadStorage,
    pub buffers: &'static mut Buffers,
}

/// What the reset code calls.
#[riscv_rt::entry]
fn start() -> ! {
    static mut STORAGE: HeadStorage = HeadStorage::new();
    static mut BUFFERS: Buffers = Buffers::new();
    let (storage, buffers) = (&raw mut STORAGE, &raw mut BUFFERS);
    // SAFETY: runs once, and nothing else can name these variables.
    let memory = unsafe { Memory { storage: &mut *storage, buffers: &mut *buffers } };
    // SAFETY: wakes the core only; interrupts as a whole stay off.
    unsafe { mie::set_mtimer() };
    crate::main(memory)
}

/// The 16550 of the board.
pub fn uart() -> Words {
    // SAFETY: the registers of a device that only this program uses, and only once.
    unsafe { Words::new(0x1000_0000, 2) }
}

/// The core-local timer (CLINT).
pub fn timer() -> Words {
    // SAFETY: as for the serial port.
    unsafe { Words::new(0x0200_0000, 0xC000 / 4) }
}

/// The device that ends QEMU.
pub fn test_device() -> Words {
    // SAFETY: as for the serial port.
    unsafe { Words::new(0x0010_0000, 1) }
}
