//! Camera head on the QEMU machine mps2-an386.
//!
//! The camera leaves a frame in the mailbox; the head pushes its rows into the detector and sends one report over
//! UART0. See `README.md` beside this package.

#![no_std]
#![no_main]

mod hardware;
mod head;
mod mailbox;
mod protocol;
mod uart;

use core::fmt::Write as _;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::hio::{self, HostStream};

use hardware::Words;
use head::{Buffers, Head};
use mailbox::Mailbox;
use protocol::{Answer, Frame, HeadStorage, Order, Outcome};
use uart::Uart;

/// Clock of the processor on this board, Hz.
const CLOCK: u32 = 25_000_000;

#[entry]
fn main() -> ! {
    static mut STORAGE: HeadStorage = HeadStorage::new();
    static mut BUFFERS: Buffers = Buffers::new();

    if let Some(peripherals) = cortex_m::Peripherals::take() {
        start_tick(peripherals.SYST);
    }
    let mut log = hio::hstderr().ok();
    let mut head = Head::new(Uart::new(Words::uart0()), STORAGE, BUFFERS);
    let mut mailbox = Mailbox::open(Words::mailbox());
    loop {
        let Some((number, order)) = mailbox.next() else {
            cortex_m::asm::wfi();
            continue;
        };
        let answer = match order {
            Some(Order::Measure(frame)) => {
                let answer = head.measure(number, &frame, &mailbox);
                note(&mut log, number, &frame, &answer);
                answer
            }
            Some(Order::Exit(status)) => hardware::exit(status),
            None => Answer::refused(Outcome::UnknownOrder),
        };
        mailbox.answer(number, answer);
    }
}

/// Logs what became of a frame.
fn note(log: &mut Option<HostStream>, number: u32, frame: &Frame, answer: &Answer) {
    let Some(log) = log else { return };
    let (Frame { width, height, .. }, Answer { outcome, targets, .. }) = (frame, answer);
    // A head without a debugger has nobody to tell that its log is lost.
    let _ = match outcome {
        Outcome::Done => writeln!(log, "frame {number}: {width}x{height}, {targets} targets"),
        refusal => writeln!(log, "frame {number}: {width}x{height}, refused: {}", refusal.reason()),
    };
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
