//! Everything that needs `unsafe`: device registers and the mailbox, read and written word by word, and the
//! calls to the debugger and to nowhere.

#![allow(unsafe_code)]

use core::panic::PanicInfo;
use core::ptr;

/// Words of memory that somebody else changes, too: a device or the camera.
pub struct Words {
    start: *mut u32,
    length: usize,
}

impl Words {
    /// UART0 of the board (CMSDK APB UART).
    pub fn uart0() -> Self {
        Self { start: ptr::without_provenance_mut(0x4000_4000), length: 5 }
    }

    /// The mailbox, where `memory.x` puts it.
    pub fn mailbox() -> Self {
        unsafe extern "C" {
            static mut _mailbox_start: u32;
            static mut _mailbox_end: u32;
        }
        let (start, end) = (&raw mut _mailbox_start, &raw mut _mailbox_end);
        Self { start, length: (end.addr() - start.addr()) / size_of::<u32>() }
    }

    /// Number of words.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Word `index`; 0 past the end.
    #[inline]
    pub fn read(&self, index: usize) -> u32 {
        if index >= self.length {
            return 0;
        }
        // SAFETY: the word lies within a range of the board's memory map that no Rust object lives in.
        unsafe { self.start.add(index).read_volatile() }
    }

    /// Writes word `index`; nothing past the end.
    #[inline]
    pub fn write(&mut self, index: usize, word: u32) {
        if index < self.length {
            // SAFETY: as in `read`.
            unsafe { self.start.add(index).write_volatile(word) }
        }
    }
}

/// Ends the program: QEMU exits with `status`.
pub fn exit(status: u32) -> ! {
    const EXIT_EXTENDED: usize = 0x20;
    const APPLICATION_EXIT: usize = 0x2_0026;
    loop {
        // SAFETY: the call reads the two words of the block and nothing else.
        unsafe {
            cortex_m_semihosting::syscall(EXIT_EXTENDED, &[APPLICATION_EXIT, status as usize]);
        }
    }
}

/// Calls a function that exists nowhere: as long as any path leads here, the program does not link.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    unsafe extern "C" {
        fn a_panic_is_reachable() -> !;
    }
    // SAFETY: never runs, because a program with this call in it cannot be linked.
    unsafe { a_panic_is_reachable() }
}
