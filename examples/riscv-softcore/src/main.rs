//! Camera head on a RISC-V core without floating-point unit, as it sits beside a sensor in an FPGA; here on the QEMU machine
//! virt.
//!
//! The camera leaves a frame in the mailbox; the head pushes its rows into the detector and sends one report over the
//! 16550. See `README.md` beside this package.

#![no_std]
#![no_main]

mod hardware;
mod uart;

use core::fmt;

use concentric_mailbox_head::{Board, Words, run};

use hardware::Memory;
use uart::Uart;

fn main(memory: Memory) -> ! {
    let board = Virt { timer: hardware::timer(), test_device: hardware::test_device() };
    run(board, Uart::new(hardware::uart()), Words::mailbox(), (memory.storage, memory.buffers))
}

struct Virt {
    timer: Words,
    test_device: Words,
}

/// No log: the board's only way out is its line, which belongs to the reports.
#[derive(Debug)]
enum NoLog {}

impl fmt::Write for NoLog {
    fn write_str(&mut self, _: &str) -> fmt::Result {
        match *self {}
    }
}

impl Board for Virt {
    type Log = NoLog;

    fn log(&mut self) -> Option<&mut NoLog> {
        None
    }

    /// Sleeps for a millisecond: the timer wakes the core without an interrupt handler, because interrupts stay off.
    fn wait(&mut self) {
        const TICKS: u64 = hardware::TIMER_HZ / 1000;
        let now = u64::from(self.timer.read(hardware::TIME_LOW))
            | u64::from(self.timer.read(hardware::TIME_HIGH)) << 32;
        let then = now.wrapping_add(TICKS);
        // The upper word first, so that no value in between is in the past.
        self.timer.write(hardware::COMPARE_HIGH, u32::MAX);
        self.timer.write(hardware::COMPARE_LOW, then as u32);
        self.timer.write(hardware::COMPARE_HIGH, (then >> 32) as u32);
        riscv::asm::wfi();
    }

    fn exit(&mut self, status: u32) -> ! {
        const PASS: u32 = 0x5555;
        const FAIL: u32 = 0x3333;
        loop {
            self.test_device.write(0, if status == 0 { PASS } else { status << 16 | FAIL });
        }
    }
}
