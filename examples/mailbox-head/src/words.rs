//! Memory that somebody else changes, too, read and written word by word.

#![allow(unsafe_code)]

use core::ptr;

/// Words of memory that somebody else changes, too: a device or the camera.
pub struct Words {
    start: *mut u32,
    length: usize,
}

impl Words {
    /// The words of a device at `address`.
    ///
    /// # Safety
    /// `length` words from there on belong to nobody else in the program, for as long as it runs.
    pub const unsafe fn new(address: usize, length: usize) -> Self {
        Self { start: ptr::without_provenance_mut(address), length }
    }

    /// The mailbox, where the board's `memory.x` puts it.
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

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.length == 0
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

    /// Byte `index` of a device whose registers are bytes; 0 past the end.
    #[inline]
    pub fn read_byte(&self, index: usize) -> u8 {
        if index / 4 >= self.length {
            return 0;
        }
        // SAFETY: as in `read`.
        unsafe { self.start.cast::<u8>().add(index).read_volatile() }
    }

    /// Writes byte `index`; nothing past the end.
    #[inline]
    pub fn write_byte(&mut self, index: usize, byte: u8) {
        if index / 4 < self.length {
            // SAFETY: as in `read`.
            unsafe { self.start.cast::<u8>().add(index).write_volatile(byte) }
        }
    }
}
