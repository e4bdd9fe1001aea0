//! A head's line on embassy: two pipes that the head uses without ever waiting, and two tasks that carry their bytes to
//! and from whatever awaits, a buffered UART or a USB serial port.

#![no_std]

use core::convert::Infallible;

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

/// Bytes of commands that can wait.
const BACK: usize = 64;

/// The pipes of a line, `N` bytes on the way out.
pub struct Pipes<const N: usize> {
    out: Pipe<CriticalSectionRawMutex, N>,
    back: Pipe<CriticalSectionRawMutex, BACK>,
}

impl<const N: usize> Pipes<N> {
    /// Empty pipes.
    pub const fn new() -> Self {
        Self { out: Pipe::new(), back: Pipe::new() }
    }

    /// Carries reports to the port, for ever. An error of the port costs the bytes that it was given.
    pub async fn send(&self, mut port: impl embedded_io_async::Write) -> ! {
        let mut bytes = [0; 64];
        loop {
            let len = self.out.read(&mut bytes).await;
            if let Some(bytes) = bytes.get(..len) {
                let _ = port.write_all(bytes).await;
            }
        }
    }

    /// Carries commands from the port, for ever. An error of the port damages a command, which its checksum shows.
    pub async fn receive(&self, mut port: impl embedded_io_async::Read) -> ! {
        let mut bytes = [0; 16];
        loop {
            if let Ok(len) = port.read(&mut bytes).await
                && let Some(bytes) = bytes.get(..len)
            {
                self.back.write_all(bytes).await;
            }
        }
    }
}

impl<const N: usize> Default for Pipes<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// The head's ends of the pipes.
pub struct PipeLine<'p, const N: usize>(
    /// The pipes.
    pub &'p Pipes<N>,
);

impl<const N: usize> ErrorType for PipeLine<'_, N> {
    type Error = Infallible;
}

impl<const N: usize> WriteReady for PipeLine<'_, N> {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.out.is_full())
    }
}

impl<const N: usize> Write for PipeLine<'_, N> {
    /// Never waits: takes nothing when the pipe is full.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        Ok(self.0.out.try_write(bytes).unwrap_or(0))
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl<const N: usize> ReadReady for PipeLine<'_, N> {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.back.is_empty())
    }
}

impl<const N: usize> Read for PipeLine<'_, N> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        Ok(self.0.back.try_read(bytes).unwrap_or(0))
    }
}
