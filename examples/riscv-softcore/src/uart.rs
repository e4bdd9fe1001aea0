//! Driver of the board's serial port.

use core::convert::Infallible;

use concentric_mailbox_head::Words;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

const DATA: usize = 0;
const FIFO_CONTROL: usize = 2;
const LINE_CONTROL: usize = 3;
const LINE_STATUS: usize = 5;

const FIFO_ON_AND_EMPTY: u8 = 0b111;
const EIGHT_BITS: u8 = 0b11;
const HAS_BYTE: u8 = 1 << 0;
const TRANSMIT_EMPTY: u8 = 1 << 5;
/// Bytes that the transmitter takes once it is empty.
const FIFO: usize = 16;

/// A 16550 (Texas Instruments, "TL16C550C", 8). QEMU's needs no divider for its rate.
pub struct Uart(Words);

impl Uart {
    /// Switches the buffers on: 16 bytes each way.
    pub fn new(mut registers: Words) -> Self {
        registers.write_byte(LINE_CONTROL, EIGHT_BITS);
        registers.write_byte(FIFO_CONTROL, FIFO_ON_AND_EMPTY);
        Self(registers)
    }

    fn status(&self, bit: u8) -> bool {
        self.0.read_byte(LINE_STATUS) & bit != 0
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl WriteReady for Uart {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.status(TRANSMIT_EMPTY))
    }
}

impl Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.flush()?;
        let mut sent = 0;
        for &byte in bytes.iter().take(FIFO) {
            self.0.write_byte(DATA, byte);
            sent += 1;
        }
        Ok(sent)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        while !self.status(TRANSMIT_EMPTY) {}
        Ok(())
    }
}

impl ReadReady for Uart {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.status(HAS_BYTE))
    }
}

impl Read for Uart {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let Some(place) = bytes.first_mut() else { return Ok(0) };
        while !self.status(HAS_BYTE) {}
        *place = self.0.read_byte(DATA);
        Ok(1)
    }
}
