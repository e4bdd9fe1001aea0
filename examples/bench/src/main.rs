//! Measures the frames that lie in the board's memory and prints a line for each: number, bytes of stack and of storage,
//! the report in hexadecimal digits. With the feature `kernels` compares the kernels with their models instead.

#![no_std]
#![no_main]
// Nothing is measured.
#![cfg_attr(feature = "kernels", allow(dead_code))]

mod hardware;
mod job;
#[cfg(feature = "kernels")]
mod kernels;
mod measure;

use core::fmt::{self, Write as _};

use concentric::report::{Detail, Report, max_len};
use concentric::{Detector, Effort, Region as Part, Run, Settings};
#[cfg(target_arch = "arm")]
use cortex_m_rt::entry;
#[cfg(target_arch = "riscv32")]
use riscv_rt::entry;
use semihosting::process;
use semihosting::sys::arm_compat::sys_writec;

use job::{
    DETAIL, FULL, Large, MAGIC, MAX_TARGETS, MOST, Medium, OWN_PIXELS, QUICK, SAME_PIXELS, SETTINGS, Small,
    WHOLE, WITH_RUNS,
};
use measure::{Bytes, Frame, Region, Runs, take_word};

/// The memory of the measurement. All zero at first, so that it costs no flash.
struct Memory {
    small: Small,
    medium: Medium,
    large: Large,
    regions: [Part; MOST],
    runs: [Run; MOST],
    report: Report<MAX_TARGETS>,
    bytes: Bytes,
}

impl Memory {
    const fn new() -> Self {
        Self {
            small: Small::new(),
            medium: Medium::new(),
            large: Large::new(),
            regions: [Part { top: 0, bottom: 0, left: 0, right: 0 }; MOST],
            runs: [Run { start: 0, end: 0 }; MOST],
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
    #[cfg(feature = "kernels")]
    let done = kernels::agree();
    #[cfg(not(feature = "kernels"))]
    let done = run(hardware::memory(), hardware::frames());
    process::exit(if done.is_some() { 0 } else { 1 })
}

/// Measures every frame; `None` when the memory holds something else.
fn run(memory: &mut Memory, mut rest: &[u8]) -> Option<()> {
    (take_word(&mut rest)? == MAGIC).then_some(())?;
    let mut pixels: &[u8] = &[];
    for number in 0..take_word(&mut rest)? {
        let (width, height) = (take_word(&mut rest)? as u16, take_word(&mut rest)? as u16);
        let settings = SETTINGS.px_per_run(take_word(&mut rest)? as u16);
        let settings = settings.effort(match take_word(&mut rest)? {
            FULL => Effort::Full,
            QUICK => Effort::Quick,
            _ => return None,
        });
        frame(memory, (number, settings), (width, height), (&mut pixels, &mut rest))?;
    }
    Some(())
}

/// The regions of a frame; `None` for those of the whole frame.
fn take_regions<'m>(rest: &mut &[u8], regions: &'m mut [Part; MOST]) -> Option<Option<&'m [Part]>> {
    let count = take_word(rest)?;
    if count == WHOLE {
        return Some(None);
    }
    let regions = regions.get_mut(..count as usize)?;
    for region in regions.iter_mut() {
        let mut take = || Some(take_word(rest)? as u16);
        *region = Part { top: take()?, bottom: take()?, left: take()?, right: take()? };
    }
    Some(Some(regions))
}

/// Measures a frame; `pixels` are those of the one before.
fn frame<'a>(
    memory: &mut Memory,
    (number, settings): (u32, Settings),
    (width, height): (u16, u16),
    (pixels, rest): (&mut &'a [u8], &mut &'a [u8]),
) -> Option<()> {
    let Memory { small, medium, large, regions, runs, report, bytes } = memory;
    let regions = take_regions(rest, regions)?;
    match take_word(rest)? {
        SAME_PIXELS => {}
        OWN_PIXELS => (*pixels, *rest) = rest.split_at_checked(usize::from(width) * usize::from(height))?,
        _ => return None,
    }
    let runs = (take_word(rest)? == WITH_RUNS).then_some(Runs { rest, row: runs });
    let frame = Frame { pixels, width, height, regions, runs };
    let (mut detector, storage) = match width {
        0..=320 => (Detector::new(settings, small), Small::BYTES),
        321..=640 => (Detector::new(settings, medium), Medium::BYTES),
        _ => (Detector::new(settings, large), Large::BYTES),
    };
    // As a head would have: the noise is known from a whole frame.
    if frame.regions.is_some() && !cfg!(feature = "empty") {
        measure::see_noise(&mut detector, &frame)?;
    }
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
