//! An executor above the main one: its tasks interrupt the head in the middle of a row.

#![allow(unsafe_code)]

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};

static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Starts the executor.
pub fn spawner() -> SendSpawner {
    interrupt::SWI_IRQ_1.set_priority(Priority::P2);
    EXECUTOR.start(interrupt::SWI_IRQ_1)
}

#[interrupt]
unsafe fn SWI_IRQ_1() {
    // SAFETY: this is the interrupt that the executor was started with.
    unsafe { EXECUTOR.on_interrupt() }
}
