//! Measures the frames that lie in the board's memory and prints a line for each: number, bytes of stack and of storage,
//! the report in hexadecimal digits. See `README.md` beside this package.

#![no_std]
#![no_main]

mod hardware;
mod job;
mod measure;

use core::fmt::{self, Write as _};

use concentric::Detector;
use concentric::report::{Detail, Report, max_len};
#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;
use semihosting::process;
use semihosting::sys::arm_compat::sys_writec;

use job::{DETAIL, Large, MAGIC, MAX_TARGETS, Medium, SETTINGS, Small};
use measure::{Bytes, Region};

/// The memory of the measurement. All zero at first, so that it costs no flash.
struct Memory {
    small: Small,
    medium: Medium,
    large: Large,
    report: Report<MAX_TARGETS>,
    bytes: Bytes,
}

impl Memory {
    const fn new() -> Self {
        Self {
            small: Small::new(),
            medium: Medium::new(),
            large: Large::new(),
            report: Report::new(Detail::Terse),
            bytes: [0; max_len(MAX_TARGETS, DETAIL)],
        }
    }
}

/// The emulator's console.
struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(sys_writec);
        Ok(())
    }
}

#[entry]
fn main() -> ! {
    let done = run(hardware::memory(), hardware::frames());
    process::exit(if done.is_some() { 0 } else { 1 })
}

/// Measures every frame; `None` when the memory holds something else.
fn run(memory: &mut Memory, mut rest: &[u8]) -> Option<()> {
    (take_word(&mut rest)? == MAGIC).then_some(())?;
    for number in 0..take_word(&mut rest)? {
        let (width, height) = (take_word(&mut rest)? as u16, take_word(&mut rest)? as u16);
        let (pixels, after) = rest.split_at_checked(usize::from(width) * usize::from(height))?;
        rest = after;
        frame(memory, number, (pixels, width, height))?;
    }
    Some(())
}

fn take_word(rest: &mut &[u8]) -> Option<u32> {
    let (word, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(u32::from_le_bytes(*word))
}

fn frame(memory: &mut Memory, number: u32, frame: (&[u8], u16, u16)) -> Option<()> {
    let Memory { small, medium, large, report, bytes } = memory;
    let (mut detector, storage) = match frame.1 {
        0..=320 => (Detector::new(SETTINGS, small), Small::BYTES),
        321..=640 => (Detector::new(SETTINGS, medium), Medium::BYTES),
        _ => (Detector::new(SETTINGS, large), Large::BYTES),
    };
    *report = Report::new(DETAIL);
    report.begin(number);
    let (sent, stack) = hardware::with_stack(|| {
        if cfg!(feature = "empty") {
            None
        } else {
            measure::measure_frame(&mut detector, frame, report, bytes)
        }
    });
    hardware::mark(Region::End);
    write!(Console, "{number} {stack} {storage} ").ok()?;
    for byte in sent? {
        write!(Console, "{byte:02x}").ok()?;
    }
    writeln!(Console).ok()
}
