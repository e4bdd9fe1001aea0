//! What the camera heads on emulated boards have in common.
//!
//! The camera leaves a frame in the mailbox ([`protocol`]); the head pushes its rows into the detector and sends one
//! report over its line, on which it also takes commands. A board adds its registers: [`run`] does the rest.

#![no_std]

mod head;
mod mailbox;
pub mod protocol;
mod words;

pub use head::Buffers;
pub use words::Words;

use core::convert::Infallible;
use core::fmt;

use concentric::head::Line;

use head::MailboxHead;
use mailbox::Mailbox;
use protocol::{Answer, HeadStorage, Order, Outcome};

/// What a board has to offer besides its line.
pub trait Board {
    /// Where the log goes.
    type Log: fmt::Write;

    /// The log, if somebody reads it.
    fn log(&mut self) -> Option<&mut Self::Log>;

    /// Returns when there may be something to do, after a millisecond at the latest.
    fn wait(&mut self);

    /// Ends the program: the emulator exits with this status.
    fn exit(&mut self, status: u32) -> !;
}

/// Takes orders from the mailbox for ever.
pub fn run<B: Board, L: Line<Error = Infallible>>(
    mut board: B,
    line: L,
    mailbox: Words,
    (storage, buffers): (&'static mut HeadStorage, &'static mut Buffers),
) -> ! {
    let mut head = MailboxHead::new(line, storage, buffers);
    let mut mailbox = Mailbox::open(mailbox);
    loop {
        head.serve();
        let Some((number, order)) = mailbox.next() else {
            board.wait();
            continue;
        };
        let answer = match order {
            Some(Order::Measure(frame) | Order::MeasureWithRuns(frame)) => {
                let size = (frame.width, frame.height);
                let runs = matches!(order, Some(Order::MeasureWithRuns(_)));
                let answer = match head.set(&frame) {
                    Ok(()) => head.measure(number, size, &mailbox, runs),
                    Err(_) => Answer::refused(Outcome::WrongSettings),
                };
                note(&mut board, number, size, &answer);
                answer
            }
            Some(Order::MeasureAsSet { width, height }) => {
                let answer = head.measure(number, (width, height), &mailbox, false);
                note(&mut board, number, (width, height), &answer);
                answer
            }
            Some(Order::Exit(status)) => board.exit(status),
            None => Answer::refused(Outcome::UnknownOrder),
        };
        mailbox.answer(number, answer);
    }
}

/// Logs what became of a frame.
fn note<B: Board>(board: &mut B, number: u32, (width, height): (u32, u32), answer: &Answer) {
    use fmt::Write;

    let Some(log) = board.log() else { return };
    // A head without a debugger has nobody to tell that its log is lost.
    let _ = match answer {
        Answer { outcome: Outcome::Done, targets, .. } => {
            writeln!(log, "frame {number}: {width}x{height}, {targets} targets")
        }
        Answer { outcome, .. } => {
            writeln!(log, "frame {number}: {width}x{height}, refused: {}", outcome.reason())
        }
    };
}

/// Calls a function that exists nowhere: as long as any path leads here, the program does not link.
#[cfg(target_os = "none")]
#[allow(unsafe_code)]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_is_reachable() -> !;
    }
    // SAFETY: never runs, because a program with this call in it cannot be linked.
    unsafe { a_panic_is_reachable() }
}
