//! Camera head on the QEMU machines mps2-an386 (Cortex-M4F) and mps2-an500 (Cortex-M7).
//!
//! The camera leaves a frame in the mailbox; the head pushes its rows into the detector and sends one report over
//! UART0. See `README.md` beside this package.

#![no_std]
#![no_main]

mod hardware;
mod uart;

use concentric_mailbox_head::protocol::HeadStorage;
use concentric_mailbox_head::{Board, Buffers, Words, run};
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::hio::{self, HostStream};

use uart::Uart;

/// Clock of the processor on these boards, Hz.
const CLOCK: u32 = 25_000_000;

#[entry]
fn main() -> ! {
    static mut STORAGE: HeadStorage = HeadStorage::new();
    static mut BUFFERS: Buffers = Buffers::new();

    if let Some(peripherals) = cortex_m::Peripherals::take() {
        start_tick(peripherals.SYST);
    }
    let board = Mps2 { log: hio::hstderr().ok() };
    run(board, Uart::new(hardware::uart0()), Words::mailbox(), (STORAGE, BUFFERS))
}

struct Mps2 {
    log: Option<HostStream>,
}

impl Board for Mps2 {
    type Log = HostStream;

    fn log(&mut self) -> Option<&mut HostStream> {
        self.log.as_mut()
    }

    fn wait(&mut self) {
        cortex_m::asm::wfi();
    }

    fn exit(&mut self, status: u32) -> ! {
        hardware::exit(status)
    }
}

/// Wakes the processor every millisecond, so that it can sleep between two looks into the mailbox.
fn start_tick(mut timer: SYST) {
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(CLOCK / 1000 - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
}

#[exception]
fn SysTick() {}
