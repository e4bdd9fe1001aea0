//! Blocking driver of the board's first serial port.

use core::convert::Infallible;

use embedded_io::{ErrorType, Write};

use crate::hardware::Words;

const DATA: usize = 0;
const STATE: usize = 1;
const CONTROL: usize = 2;
const BAUD_DIVIDER: usize = 4;

const TRANSMIT_FULL: u32 = 1 << 0;
const TRANSMIT_ENABLE: u32 = 1 << 0;

/// CMSDK APB UART with a one-byte transmit buffer (Arm, "Cortex-M System Design Kit TRM", 4.3).
pub struct Uart(Words);

impl Uart {
    /// Switches the transmitter on.
    pub fn new(mut registers: Words) -> Self {
        // The smallest divider that the device takes: 25 MHz / 16 = 1.56 Mbaud.
        registers.write(BAUD_DIVIDER, 16);
        registers.write(CONTROL, TRANSMIT_ENABLE);
        Self(registers)
    }

    fn wait_for_room(&self) {
        while self.0.read(STATE) & TRANSMIT_FULL != 0 {}
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Write for Uart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for &byte in bytes {
            self.wait_for_room();
            self.0.write(DATA, byte.into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        self.wait_for_room();
        Ok(())
    }
}
