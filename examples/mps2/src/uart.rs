//! Driver of the boards' first serial port.

use core::convert::Infallible;

use concentric_mailbox_head::Words;
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

const DATA: usize = 0;
const STATE: usize = 1;
const CONTROL: usize = 2;
const BAUD_DIVIDER: usize = 4;

const TRANSMIT_FULL: u32 = 1 << 0;
const RECEIVE_FULL: u32 = 1 << 1;
const TRANSMIT_ENABLE: u32 = 1 << 0;
const RECEIVE_ENABLE: u32 = 1 << 1;

/// CMSDK APB UART with a one-byte buffer each way (Arm, "Cortex-M System Design Kit TRM", 4.3).
pub struct Uart(Words);

impl Uart {
    /// Switches transmitter and receiver on.
    pub fn new(mut registers: Words) -> Self {
        // The smallest divider that the device takes: 25 MHz / 16 = 1.56 Mbaud.
        registers.write(BAUD_DIVIDER, 16);
        registers.write(CONTROL, TRANSMIT_ENABLE | RECEIVE_ENABLE);
        Self(registers)
    }

    fn has_room(&self) -> bool {
        self.0.read(STATE) & TRANSMIT_FULL == 0
    }

    fn has_byte(&self) -> bool {
        self.0.read(STATE) & RECEIVE_FULL != 0
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl WriteReady for Uart {
    fn write_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.has_room())
    }
}

impl Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let Some(&byte) = bytes.first() else { return Ok(0) };
        self.flush()?;
        self.0.write(DATA, byte.into());
        Ok(1)
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        while !self.has_room() {}
        Ok(())
    }
}

impl ReadReady for Uart {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(self.has_byte())
    }
}

impl Read for Uart {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        let Some(place) = bytes.first_mut() else { return Ok(0) };
        while !self.has_byte() {}
        *place = self.0.read(DATA) as u8;
        Ok(1)
    }
}
